/* driftlab check: whether the energy drifts, as a test that scripts can run. */
#include <stdio.h>
#include <string.h>

#include "cli/command.h"
#include "cli/finding.h"
#include "cli/outcome.h"
#include "cli/settings.h"

typedef struct check_values {
    char *method, *dt, *rtol;
    double t_end, sample, time_limit;
    bool json;
} check_values;

static const dl_parameter options[] = {
    CLI_OPTION_METHOD(check_values),
    CLI_OPTION_DT(check_values),
    CLI_OPTION_RTOL(check_values),
    CLI_OPTION_T_END(check_values),
    CLI_OPTION_POSITIVE(check_values, "sample", sample, "X",
                        "time between samples (default: a thousandth of the run)"),
    CLI_OPTION_TIME_LIMIT(check_values, "CPU time of each of its runs (default: none)"),
    CLI_OPTION_JSON(check_values),
};

static cli_exit check(const cli_input *input) {
    const check_values *values = input->values;
    const cli_measurement asked = {.kind = "drift",
                                   .scene = input->word[0],
                                   .method = values->method,
                                   .dt = values->dt,
                                   .rtol = values->rtol,
                                   .end = values->t_end,
                                   .sample = values->sample,
                                   .seconds = values->time_limit};
    dl_finding finding = {0};
    dl_error error = {""};
    dl_status status = cli_measure(input, &asked, &finding, &error);
    if (!status && finding.status)
        status = dl_fail(&error, finding.status, "%s", finding.message);
    if (!status && values->json)
        status = cli_finding_json(&finding, stdout, &error);
    else if (!status)
        printf("%s: %s with %s %s: %s\n", finding.verdict, finding.scene, finding.method,
               finding.options, finding.reason);
    const bool passed = !status && strcmp(finding.verdict, "pass") == 0;
    dl_finding_release(&finding);
    return status || passed ? cli_finish(status, &error) : CLI_FAILED;
}

static const cli_repeated set = {
    "set", "KEY=VALUE", "an option of the method, or allow, levels, slack, reversal (help study)",
    true};

const cli_command cli_command_check = {
    .name = "check",
    .arguments = "SCENE",
    .summary = "test that a method's energy does not drift on a scene: exit status 0 or 1",
    .details =
        "Runs the scene with the step X, X/2 and X/4 (or rtol, rtol/10, rtol/100), and passes "
        "where\n"
        "  - the straight line through the energy error changes it by no more over the run than "
        "its\n"
        "    fluctuation about the line, with 95 % confidence (--set allow=1e-6: by no more than\n"
        "    1e-6 of the energy's scale instead);\n"
        "  - the fluctuation falls with the step as the method's order says (fixed steps;\n"
        "    --set levels=1: not asked, and the scene is run once);\n"
        "  - what the method is to conserve exactly, it does, to roundoff; and one that is\n"
        "    time-symmetric returns to where it began when it is run back.\n"
        "What walls and radiation take is no error. Prints the verdict and why, on one line.\n"
        "\n"
        "exit status: 0 pass; 1 fail, or not measurable: a test that could not be made has not "
        "been\n"
        "passed (the energy error is roundoff already, the run is too short, the limit on time "
        "was\n"
        "reached); 2 bad input. In a test script:\n"
        "\n"
        "    driftlab check drop.yaml --method leapfrog --dt 1e-4 --t-end 0.5 || exit 1\n",
    .least_words = 1,
    .most_words = 1,
    .repeated = &set,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(check_values),
    .run = check,
};
