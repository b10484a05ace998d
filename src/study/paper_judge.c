/* The verdict, by the rule that the claim states and nothing else. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/paper_plan.h"

const char *dl_verdict_name(dl_verdict verdict) {
    static const char *const names[] = {
        [DL_AGREES] = "agrees",    [DL_DIFFERS] = "differs",
        [DL_AS_SAID] = "as said",  [DL_NOT_AS_SAID] = "not as said",
        [DL_INPUT_DATA] = "input", [DL_NOT_COMPUTABLE] = "not computable"};
    return names[verdict];
}

/* Unit of the last digit of a number as it is printed: 0.001 of "20.467", 0.01 of ".50". */
static double last_digit(const char *text) {
    const char *const point = strchr(text, '.');
    const char *const power = strpbrk(text, "eE");
    const size_t decimals = point ? strspn(point + 1, "0123456789") : 0;
    return pow(10, (power ? strtod(power + 1, NULL) : 0) - (double)decimals);
}

bool dl_paper_has_no_number(const dl_paper_claim *claim) {
    return strcmp(claim->computed, "none") == 0;
}

bool dl_paper_has_words(const dl_paper_claim *claim) {
    return *claim->criterion;
}

static bool read_number(const char *text, double *value) {
    char *end;
    *value = strtod(text, &end);
    return end != text && !*end && isfinite(*value);
}

/* Words have a criterion, which is a number; a number has none. */
static dl_status read_published(dl_paper_claim *claim, dl_error *error) {
    if (!dl_paper_has_words(claim))
        return read_number(claim->published, &claim->value)
                   ? DL_OK
                   : dl_fail(error, DL_INPUT,
                             "published: found \"%s\", expected a number, or `criterion` beside "
                             "words",
                             claim->published);
    double printed;
    if (read_number(claim->published, &printed) || claim->input)
        return dl_fail(error, DL_INPUT,
                       "criterion: found \"%s\", expected it beside words alone, and no `input`",
                       claim->criterion);
    return read_number(claim->criterion, &claim->value)
               ? DL_OK
               : dl_fail(error, DL_INPUT, "criterion: found \"%s\", expected a number",
                         claim->criterion);
}

static dl_status prepare_words_alone(const dl_paper_claim *claim, dl_error *error) {
    if (dl_paper_has_words(claim))
        return dl_fail(error, DL_INPUT,
                       "criterion: found \"%s\", expected none where nothing is computed",
                       claim->criterion);
    return *claim->reason
               ? DL_OK
               : dl_fail(error, DL_INPUT, "reason: found none, expected why nothing is computed");
}

dl_status dl_paper_claim_prepare(dl_paper_claim *claim, dl_error *error) {
    claim->value = claim->tolerance = NAN;
    if (dl_paper_has_no_number(claim))
        return prepare_words_alone(claim, error);
    if (*claim->reason)
        return dl_fail(error, DL_INPUT,
                       "reason: found \"%.80s\", expected it beside `computed: "
                       "none` alone",
                       claim->reason);
    const dl_status status = read_published(claim, error);
    if (status)
        return status;
    if ((claim->digit > 0) + (claim->about > 0) + (isfinite(claim->within)) > 1)
        return dl_fail(error, DL_INPUT,
                       "digit, about, within: found more than one of them, expected one");
    if (claim->about > 0)
        claim->tolerance = claim->about * fabs(claim->value);
    else if (isfinite(claim->within))
        claim->tolerance = claim->within;
    else
        claim->tolerance =
            0.5 * (claim->digit > 0 ? claim->digit
                                    : last_digit(dl_paper_has_words(claim) ? claim->criterion
                                                                           : claim->published));
    return DL_OK;
}

static void write_criterion(const dl_paper_claim *claim, char *text, size_t size) {
    if (claim->rule == DL_RULE_EQUAL)
        snprintf(text, size, "criterion: %.40s within %.3g", claim->criterion, claim->tolerance);
    else
        snprintf(text, size, "criterion: at %s %.40s",
                 claim->rule == DL_RULE_AT_LEAST ? "least" : "most", claim->criterion);
}

static void write_rule(const dl_paper_claim *claim, char *text, size_t size) {
    if (dl_paper_has_no_number(claim))
        snprintf(text, size, "not judged");
    else if (dl_paper_has_words(claim))
        write_criterion(claim, text, size);
    else if (claim->rule == DL_RULE_AT_LEAST)
        snprintf(text, size, "at least what is printed");
    else if (claim->rule == DL_RULE_AT_MOST)
        snprintf(text, size, "at most what is printed");
    else if (claim->about > 0)
        snprintf(text, size, "\"about\": within %.3g %%", 100 * claim->about);
    else if (isfinite(claim->within))
        snprintf(text, size, "within %.3g", claim->within);
    else
        snprintf(text, size, "half a unit of the last digit: %.3g", claim->tolerance);
}

/* A difference that is the tolerance but for roundoff is within it. */
static bool holds(const dl_paper_claim *claim, double difference) {
    const double slack = 1e-9 * fmax(fabs(claim->value), claim->tolerance);
    if (claim->rule == DL_RULE_AT_LEAST)
        return difference >= -slack;
    if (claim->rule == DL_RULE_AT_MOST)
        return difference <= slack;
    return fabs(difference) <= claim->tolerance + slack;
}

void dl_paper_judge(const dl_paper_claim *claim, dl_paper_row *row) {
    const double difference = row->value - claim->value;
    const bool words = dl_paper_has_words(claim);
    write_rule(claim, row->rule, sizeof row->rule);
    row->difference = words ? NAN : difference;
    row->tolerance = claim->tolerance;
    if (!isfinite(row->value))
        row->verdict = DL_NOT_COMPUTABLE;
    else if (words)
        row->verdict = holds(claim, difference) ? DL_AS_SAID : DL_NOT_AS_SAID;
    else if (!holds(claim, difference))
        row->verdict = DL_DIFFERS;
    else
        row->verdict = claim->input ? DL_INPUT_DATA : DL_AGREES;
}
