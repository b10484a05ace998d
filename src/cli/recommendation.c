#include "cli/recommendation.h"

#include <math.h>
#include <string.h>

#include "cli/json.h"

static bool in_energy(const dl_recommendation *found) {
    return strcmp(found->in, "energy") == 0;
}

static bool is_whole(const dl_recommendation *found) {
    return found->measured_to >= found->end;
}

/* Runners-up that cost about the same. */
static size_t ties(const dl_recommendation *found) {
    size_t count = 0;
    while (count + 1 < found->reached && found->method[count + 1].point.cpu_seconds <
                                             DL_RECOMMEND_TIE * found->method[0].point.cpu_seconds)
        count++;
    return count;
}

/* "arkode-erk table=fehlberg-8" */
static void name_of(const dl_recommended *method, char text[128]) {
    snprintf(text, 128, "%s%s%s", method->row->name, *method->variant ? " " : "", method->variant);
}

static const char *ratio_words(double ratio, char text[48]) {
    snprintf(text, 48,
             ratio < DL_RECOMMEND_TIE ? "%.2f times as long: a tie" : "%.3g times as long", ratio);
    return text;
}

/* --- text --------------------------------------------------------------------------------------
 */

static void print_head(const dl_recommendation *found, FILE *out) {
    fprintf(out, "%s to t = %.6g, error %g in %s", found->scene, found->end, found->error,
            found->in);
    if (in_energy(found))
        fputs(" (largest over the run, in units of its scale)\n", out);
    else
        fputs(" (RMS over the particles at the end, in the scene's unit of length)\n", out);
    if (is_whole(found))
        fputs("measured on the whole run\n", out);
    else
        fprintf(out, "measured on a run to t = %.6g, %.2g %% of the whole: %s\n",
                found->measured_to, 100 * found->measured_to / found->end, found->shortened);
    if (!in_energy(found))
        fprintf(out, "against a reference in extended precision, its own error %.1e\n",
                found->reference_error);
}

static void print_neighbour(const dl_recommended *first, const char *word,
                            const dl_recommend_point *point, FILE *out) {
    if (!*point->setting)
        return;
    fprintf(out, "  %s %s: ", word, point->setting);
    if (isfinite(point->error))
        fprintf(out, "error %.2e, which %s; %lu forces\n", point->error,
                point->error <= first->target ? "reaches it too" : "does not reach it",
                point->force_evaluations);
    else
        fprintf(out, "does not count: %s\n", point->note);
}

/* How the shortened run's error is taken to go on. */
static const char *const growth_words[] = {"staying as it is", "growing as t", "growing as t^2"};

static void print_whole(const dl_recommendation *found, const dl_recommended *first, FILE *out) {
    char share[160] = "";
    if (!is_whole(found))
        snprintf(share, sizeof share, ", %.3g times the measured one's",
                 found->end / found->measured_to);
    fprintf(out, "  whole run: about %.2e CPU s, %.3g forces%s", first->full_cpu_seconds,
            first->full_force_evaluations, share);
    if (found->part_only)
        fprintf(out, "; the error is the measured run's: %s", found->part_only);
    else if (!is_whole(found))
        fprintf(out, "; error %.1e, %s", first->full_error, growth_words[lround(first->growth)]);
    fprintf(out, "\n  %s\n", first->command);
}

static void print_first(const dl_recommendation *found, FILE *out) {
    const dl_recommended *first = &found->method[0];
    char name[128];
    name_of(first, name);
    fprintf(out, "recommended: %s with %s\n", name, first->point.setting);
    fprintf(out, "  measured: error %.2e, %.2e CPU s, %lu forces, %lu steps\n", first->point.error,
            first->point.cpu_seconds, first->point.force_evaluations, first->point.steps);
    if (first->target < found->error)
        fprintf(out, "  asked of the measured run: %.2e, so that the whole reaches %g\n",
                first->target, found->error);
    print_neighbour(first, "coarser", &first->coarser, out);
    print_neighbour(first, "finer", &first->finer, out);
    print_whole(found, first, out);
    if (in_energy(found) && first->row->flags & DL_CONSERVES_ENERGY)
        fputs("  it conserves energy at any step: no longer one than the scene's was tried, and "
              "its\n  energy says nothing of its positions\n",
              out);
}

static void print_why(const dl_recommendation *found, FILE *out) {
    const double cheapest = found->method[0].point.cpu_seconds;
    char name[128], ratio[48];
    fprintf(out, "why: the least CPU time of the %zu of %zu methods that reached it",
            found->reached, found->methods);
    if (found->reached > 1) {
        name_of(&found->method[1], name);
        fprintf(out, "; the next, %s, takes %s", name,
                ratio_words(found->method[1].point.cpu_seconds / cheapest, ratio));
    }
    fputs(ties(found) ? " (times within 20 % of each other are a tie)\n" : "\n", out);
}

static void print_table(const dl_recommendation *found, FILE *out) {
    char name[128];
    size_t wide = strlen("method"), widest = strlen("setting");
    for (size_t i = 0; i < found->reached; i++) {
        name_of(&found->method[i], name);
        wide = strlen(name) > wide ? strlen(name) : wide;
        const size_t setting = strlen(found->method[i].point.setting);
        widest = setting > widest ? setting : widest;
    }
    fprintf(out, "  %-*s  %-*s %9s %7s %9s %9s\n", (int)wide, "method", (int)widest, "setting",
            "CPU s", "times", "forces", "error");
    for (size_t i = 0; i < found->reached; i++) {
        const dl_recommend_point *point = &found->method[i].point;
        const double ratio = point->cpu_seconds / found->method[0].point.cpu_seconds;
        name_of(&found->method[i], name);
        fprintf(out, "  %-*s  %-*s %9.2e %7.2f %9lu %9.2e%s\n", (int)wide, name, (int)widest,
                point->setting, point->cpu_seconds, ratio, point->force_evaluations, point->error,
                i > 0 && ratio < DL_RECOMMEND_TIE ? "  tie" : "");
    }
}

static void print_left_out(const dl_recommendation *found, FILE *out) {
    char name[128];
    if (found->reached < found->methods)
        fputs("left out:\n", out);
    for (size_t i = found->reached; i < found->methods; i++) {
        const dl_recommended *method = &found->method[i];
        name_of(method, name);
        fprintf(out, "  %s: %s", name, method->reason);
        if (isfinite(method->point.error))
            fprintf(out, "; nearest %.2e with %s", method->point.error, method->point.setting);
        fputc('\n', out);
    }
}

void cli_recommendation_print(const dl_recommendation *found, FILE *out) {
    print_head(found, out);
    if (found->reached) {
        print_first(found, out);
        print_why(found, out);
        print_table(found, out);
    }
    print_left_out(found, out);
}

void cli_recommendation_why_not(const dl_recommendation *found, dl_error *error) {
    char name[128], nearest[400] = "no run to its end counts";
    if (found->methods && isfinite(found->method[0].point.error)) {
        name_of(&found->method[0], name);
        snprintf(nearest, sizeof nearest, "the nearest is %s with %s: %.2e", name,
                 found->method[0].point.setting, found->method[0].point.error);
    }
    dl_fail(error, DL_ERROR, "no method reached an error of %g in %s on %s%s; %s (%.300s)",
            found->error, found->in, found->scene,
            in_energy(found) || found->reference_error <= found->error
                ? ""
                : ", which the reference itself is not known to",
            nearest, found->methods ? found->method[0].reason : "no methods");
}

/* --- JSON --------------------------------------------------------------------------------------
 */

/* null where there is none. */
static json_t *point_of(const dl_recommend_point *point) {
    if (!*point->setting)
        return json_null();
    json_t *object = json_object();
    json_object_set_new(object, "setting", json_string(point->setting));
    json_object_set_new(object, "error", cli_json_real(point->error));
    json_object_set_new(object, "cpu_seconds", cli_json_real(point->cpu_seconds));
    json_object_set_new(object, "force_evaluations",
                        json_integer((json_int_t)point->force_evaluations));
    json_object_set_new(object, "steps", json_integer((json_int_t)point->steps));
    json_object_set_new(object, "note", json_string(point->note));
    return object;
}

/* {"step": 0.01}: what `driftlab run --set` takes. */
static json_t *options_of(const dl_recommended *method) {
    json_t *object = json_object();
    char text[sizeof method->variant + sizeof method->point.setting + 1], *rest = NULL;
    snprintf(text, sizeof text, "%s %s", method->variant, method->point.setting);
    for (char *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        char *const sign = strchr(word, '='), *end = NULL;
        if (!sign)
            continue;
        *sign = '\0';
        const double value = strtod(sign + 1, &end);
        json_object_set_new(object, word, *end ? json_string(sign + 1) : cli_json_real(value));
    }
    return object;
}

static json_t *reached_of(const dl_recommendation *found, const dl_recommended *method) {
    const dl_recommended *first = &found->method[0];
    const double ratio = method->point.cpu_seconds / first->point.cpu_seconds;
    json_t *object = json_object(), *whole = json_object();
    json_object_set_new(object, "method", json_string(method->row->name));
    json_object_set_new(object, "options", options_of(method));
    json_object_set_new(object, "measured", point_of(&method->point));
    json_object_set_new(object, "asked", cli_json_real(method->target));
    json_object_set_new(object, "coarser", point_of(&method->coarser));
    json_object_set_new(object, "finer", point_of(&method->finer));
    json_object_set_new(object, "times_the_cheapest", cli_json_real(ratio));
    json_object_set_new(object, "tie",
                        json_boolean(method == first ? ties(found) > 0 : ratio < DL_RECOMMEND_TIE));
    json_object_set_new(whole, "cpu_seconds", cli_json_real(method->full_cpu_seconds));
    json_object_set_new(whole, "force_evaluations", cli_json_real(method->full_force_evaluations));
    json_object_set_new(whole, "error", cli_json_real(method->full_error));
    json_object_set_new(whole, "growth",
                        found->part_only ? json_null()
                                         : json_string(growth_words[lround(method->growth)]));
    json_object_set_new(object, "expected", whole);
    json_object_set_new(object, "command", json_string(method->command));
    return object;
}

static json_t *left_out_of(const dl_recommended *method) {
    char name[128];
    name_of(method, name);
    json_t *object = json_object();
    json_object_set_new(object, "method", json_string(name));
    json_object_set_new(object, "reason", json_string(method->reason));
    json_object_set_new(object, "nearest",
                        isfinite(method->point.error) ? point_of(&method->point) : json_null());
    return object;
}

dl_status cli_recommendation_json(const dl_recommendation *found, FILE *out, dl_error *error) {
    json_t *root = json_object(), *others = json_array(), *left = json_array();
    json_object_set_new(root, "scene", json_string(found->scene));
    json_object_set_new(root, "asked_error", cli_json_real(found->error));
    json_object_set_new(root, "asked_in", json_string(found->in));
    json_object_set_new(root, "end", cli_json_real(found->end));
    json_object_set_new(root, "measured_to", cli_json_real(found->measured_to));
    json_object_set_new(root, "shortened", json_string(found->shortened));
    json_object_set_new(root, "error_of_measured_run_only",
                        found->part_only ? json_string(found->part_only) : json_null());
    json_object_set_new(root, "neighbour_distance", cli_json_real(found->length));
    json_object_set_new(root, "reference_error", cli_json_real(found->reference_error));
    json_object_set_new(root, "horizon",
                        found->horizon > 0 ? cli_json_real(found->horizon) : json_null());
    json_object_set_new(root, "recommended",
                        found->reached ? reached_of(found, &found->method[0]) : json_null());
    for (size_t i = 1; i < found->reached; i++)
        json_array_append_new(others, reached_of(found, &found->method[i]));
    for (size_t i = found->reached; i < found->methods; i++)
        json_array_append_new(left, left_out_of(&found->method[i]));
    json_object_set_new(root, "runners_up", others);
    json_object_set_new(root, "left_out", left);
    return cli_json_print(root, out, error);
}
