/* The answer of a work-precision study: the cheapest case that reaches the asked error. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/front.h"
#include "driftlab/reference.h"
#include "study/kind.h"

enum { OPTIONS_SIZE = 512 };

static bool in_energy(const char *asked_in) {
    return strcmp(asked_in, "energy") == 0;
}

static double bound(const dl_results *results, const dl_case *cased, const char *asked_in) {
    return dl_case_bound(cased, asked_in, dl_results_reference(results, cased->scene));
}

const dl_case *dl_results_cheapest(const dl_results *results, const char *scene,
                                   const char *asked_in, double error) {
    const dl_case *cheapest = NULL;
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        if (strcmp(cased->scene, scene) != 0 || !(bound(results, cased, asked_in) <= error))
            continue;
        if (!cheapest || cased->summary.cpu_seconds < cheapest->summary.cpu_seconds)
            cheapest = cased;
    }
    return cheapest;
}

static const dl_case *closest(const dl_results *results, const char *scene) {
    const dl_case *best = NULL;
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        const double reached = bound(results, cased, results->asked_in);
        if (strcmp(cased->scene, scene) == 0 && isfinite(reached) &&
            (!best || reached < bound(results, best, results->asked_in)))
            best = cased;
    }
    return best;
}

/* Length of the word "key=value" at `options`, and of its key. */
static size_t word_length(const char *options, size_t *key) {
    *key = strcspn(options, "= ");
    return strcspn(options, " ");
}

/* Whether another case of the same method on the same scene has another value of that option, or
 * there is no other case. */
static bool distinguishes(const dl_results *results, const dl_case *cased, const char *word,
                          size_t length, size_t key) {
    size_t others = 0;
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *other = &results->cased[i];
        if (other == cased || strcmp(other->method, cased->method) != 0 ||
            strcmp(other->scene, cased->scene) != 0)
            continue;
        others++;
        size_t its_key, its_length;
        for (const char *its = other->options; *its; its += its_length + (its[its_length] == ' ')) {
            its_length = word_length(its, &its_key);
            if (its_key == key && strncmp(its, word, key) == 0 &&
                (its_length != length || strncmp(its, word, length) != 0))
                return true;
        }
    }
    return others == 0;
}

/* The options that set a case apart from the others of its method. */
static void short_options(const dl_results *results, const dl_case *cased,
                          char text[OPTIONS_SIZE]) {
    size_t used = 0, key, length;
    text[0] = '\0';
    for (const char *word = cased->options; *word; word += length + (word[length] == ' ')) {
        length = word_length(word, &key);
        if (used + length + 2 > OPTIONS_SIZE || !distinguishes(results, cased, word, length, key))
            continue;
        used += (size_t)snprintf(text + used, OPTIONS_SIZE - used, "%s%.*s", used ? " " : "",
                                 (int)length, word);
    }
}

void dl_results_answer(const dl_results *results, const char *scene, char *text, size_t size) {
    if (dl_study_kind_of(results)->answer) {
        dl_study_kind_of(results)->answer(results, scene, text, size);
        return;
    }
    const char *in = results->asked_in, *article = in_energy(in) ? "an" : "a";
    const dl_case *found = dl_results_cheapest(results, scene, in, results->asked_error);
    char options[OPTIONS_SIZE];
    if (found) {
        short_options(results, found, options);
        snprintf(text, size,
                 "cheapest for %s %s error of %g on %s: %s with %s (%.3g CPU s, %lu force "
                 "evaluations; its error: %.2g)",
                 article, in, results->asked_error, scene, found->method, options,
                 found->summary.cpu_seconds, found->summary.force_evaluations,
                 dl_case_error(found, in));
        return;
    }
    found = closest(results, scene);
    if (found) {
        short_options(results, found, options);
        snprintf(text, size,
                 "nothing reached %s %s error of %g on %s; the closest was %s with %s (%.2g)",
                 article, in, results->asked_error, scene, found->method, options,
                 bound(results, found, in));
    } else {
        snprintf(text, size, "nothing reached %s %s error of %g on %s: no case ran to its end",
                 article, in, results->asked_error, scene);
    }
}

/* A number, or a dash where it does not apply. */
static const char *number(double value, char text[16]) {
    snprintf(text, 16, isfinite(value) ? "%.2e" : "-", value);
    return text;
}

typedef struct widths {
    int method, options;
} widths;

static widths measure(const dl_results *results) {
    widths wide = {(int)strlen("method"), (int)strlen("options")};
    for (size_t i = 0; i < results->cases; i++) {
        char options[OPTIONS_SIZE];
        short_options(results, &results->cased[i], options);
        const int method = (int)strlen(results->cased[i].method), option = (int)strlen(options);
        wide.method = method > wide.method ? method : wide.method;
        wide.options = option > wide.options ? option : wide.options;
    }
    return wide;
}

/* The fronts of a scene's cases in the error that was asked about. */
typedef struct fronts {
    dl_front_point *cpu, *forces;
    size_t cpus, forced;
} fronts;

static void fronts_release(fronts *of) {
    free(of->cpu);
    free(of->forces);
}

/* Empty where there is no memory for them. */
static fronts find_fronts(const dl_results *results, const char *scene) {
    fronts of = {.cpu = calloc(results->cases + 1, sizeof *of.cpu),
                 .forces = calloc(results->cases + 1, sizeof *of.forces)};
    if (of.cpu)
        of.cpus = dl_results_front(results, scene, results->asked_in, DL_COST_CPU, of.cpu);
    if (of.forces)
        of.forced = dl_results_front(results, scene, results->asked_in, DL_COST_FORCES, of.forces);
    return of;
}

static bool is_on(const dl_front_point *front, size_t count, size_t index) {
    for (size_t i = 0; i < count; i++)
        if (front[i].index == index)
            return true;
    return false;
}

static void print_case(const dl_results *results, size_t index, widths wide, const fronts *of,
                       FILE *out) {
    char seconds[16], position[16], energy[16], options[OPTIONS_SIZE];
    const dl_case *cased = &results->cased[index];
    const dl_run_summary *run = &cased->summary;
    const char *cpu = is_on(of->cpu, of->cpus, index) ? " cpu" : "";
    const char *forces = is_on(of->forces, of->forced, index) ? " forces" : "";
    const bool past = dl_case_is_past_horizon(cased, dl_results_reference(results, cased->scene));
    short_options(results, cased, options);
    fprintf(out, "  %-*s  %-*s  %-17s %9s %9lu %9lu %9s%c %9s%s%s%s\n", wide.method, cased->method,
            wide.options, options, dl_status_name(run->status), number(run->cpu_seconds, seconds),
            run->force_evaluations, run->steps,
            past ? "horizon" : number(dl_case_error(cased, "position"), position),
            *cased->refused || *cased->invalid ? '!' : ' ',
            number(dl_case_error(cased, "energy"), energy), *cpu || *forces ? " " : "", cpu,
            forces);
}

/* "METHOD OPTIONS", at least `width` wide; its length. */
static int print_name(const dl_results *results, const dl_case *cased, int width, FILE *out) {
    char options[OPTIONS_SIZE], name[2 * OPTIONS_SIZE];
    short_options(results, cased, options);
    const int length = snprintf(name, sizeof name, "%s %s", cased->method, options);
    if (out)
        fprintf(out, "%-*s", width, name);
    return length;
}

static int widest_name(const dl_results *results, const dl_front_point *front, size_t count) {
    int widest = (int)strlen("by force evaluations");
    for (size_t i = 0; i < count; i++) {
        const int length = print_name(results, &results->cased[front[i].index], 0, NULL);
        widest = length > widest ? length : widest;
    }
    return widest;
}

/* The cheapest of both fronts for an error of 10^exponent; NULL: none. */
typedef struct cheapest {
    const dl_front_point *cpu, *forces;
} cheapest;

static cheapest find_cheapest(const fronts *of, int exponent) {
    const double error = pow(10, exponent);
    return (cheapest){dl_front_cheapest(of->cpu, of->cpus, error),
                      dl_front_cheapest(of->forces, of->forced, error)};
}

static void print_cheapest(const dl_results *results, int from, int to, const cheapest *found,
                           const int width[2], FILE *out) {
    char decades[32];
    snprintf(decades, sizeof decades, from == to ? "1e%+03d" : "1e%+03d to 1e%+03d", from, to);
    fprintf(out, "    %-14s  ", decades);
    print_name(results, &results->cased[found->cpu->index], width[0], out);
    fprintf(out, " %8.2e s  ", found->cpu->cost);
    print_name(results, &results->cased[found->forces->index], width[1], out);
    fprintf(out, " %9.0f\n", found->forces->cost);
}

/* For every decade of accuracy the cheapest case; one line where decades have the same. */
static void print_accuracies(const dl_results *results, const fronts *of, FILE *out) {
    const int width[2] = {widest_name(results, of->cpu, of->cpus),
                          widest_name(results, of->forces, of->forced)};
    int largest, smallest, others, unused;
    if (!dl_front_decades(of->cpu, of->cpus, &largest, &smallest) ||
        !dl_front_decades(of->forces, of->forced, &others, &unused))
        return;
    fprintf(out, "  cheapest for %s %s error of at most\n    %-14s  %-*s %10s  %s\n",
            in_energy(results->asked_in) ? "an" : "a", results->asked_in, "", width[0],
            "by CPU time", "", "by force evaluations");
    int from = largest > others ? largest : others;
    for (int exponent = from; exponent >= smallest; exponent--) {
        const cheapest found = find_cheapest(of, exponent), next = find_cheapest(of, exponent - 1);
        if (exponent > smallest && found.cpu == next.cpu && found.forces == next.forces)
            continue;
        if (found.cpu && found.forces)
            print_cheapest(results, from, exponent, &found, width, out);
        from = exponent - 1;
    }
}

void dl_finding_print(const dl_finding *finding, FILE *out) {
    fprintf(out, "  %s%s%s: ", finding->method, *finding->options ? " " : "", finding->options);
    if (finding->status != DL_OK)
        fprintf(out, "could not be measured (%s): %s\n", dl_status_name(finding->status),
                finding->message);
    else
        fprintf(out, "%s: %s\n", finding->verdict, finding->reason);
    const char *name = finding->quantity_names;
    for (size_t i = 0; i < finding->quantities; i++) {
        const double *value = finding->quantity + 3 * i;
        const int length = (int)strcspn(name, "\n");
        fprintf(out, "    %.*s: ", length, name);
        fprintf(out, isfinite(value[0]) ? "%.6g" : "does not apply", value[0]);
        if (isfinite(value[1]) && isfinite(value[2]))
            fprintf(out, " (%.6g to %.6g)", value[1], value[2]);
        fputc('\n', out);
        name += length + (name[length] == '\n');
    }
}

static void print_findings(const dl_results *results, const char *scene, FILE *out) {
    fprintf(out, "%s\n", scene);
    for (size_t i = 0; i < results->findings; i++)
        if (strcmp(results->finding[i].scene, scene) == 0)
            dl_finding_print(&results->finding[i], out);
}

static void print_scene(const dl_results *results, const char *scene, FILE *out) {
    const widths wide = measure(results);
    fronts of = find_fronts(results, scene);
    fprintf(out,
            "%s (errors: RMS position at the end; energy, largest, in units of its scale; front: "
            "nothing else is as good in %s and as cheap)\n",
            scene, results->asked_in);
    fprintf(out, "  %-*s  %-*s  %-17s %9s %9s %9s %9s  %9s  front\n", wide.method, "method",
            wide.options, "options", "status", "CPU s", "forces", "steps", "position", "energy");
    for (size_t i = 0; i < results->cases; i++)
        if (strcmp(results->cased[i].scene, scene) == 0)
            print_case(results, i, wide, &of, out);
    print_accuracies(results, &of, out);
    fronts_release(&of);
}

static void print_reason(const dl_results *results, const dl_case *cased, FILE *out) {
    char options[OPTIONS_SIZE];
    short_options(results, cased, options);
    fprintf(out, "  ! %s %s: %s\n", cased->method, options,
            *cased->invalid ? cased->invalid : cased->refused);
}

static void print_refused(const dl_results *results, const char *scene, FILE *out) {
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        if (strcmp(cased->scene, scene) == 0 && (*cased->refused || *cased->invalid))
            print_reason(results, cased, out);
    }
}

void dl_results_print(const dl_results *results, FILE *out) {
    char answer[DL_MESSAGE_SIZE];
    for (size_t s = 0; s < results->scenes; s++) {
        const char *scene = results->scene[s].name;
        const dl_reference *reference = dl_results_reference(results, scene);
        if (dl_study_kind_of(results)->measure) {
            print_findings(results, scene, out);
            continue;
        }
        print_scene(results, scene, out);
        print_refused(results, scene, out);
        if (reference)
            dl_reference_print(reference, "  ", out);
    }
    if (dl_study_kind_of(results)->print)
        dl_study_kind_of(results)->print(results, out);
    for (size_t s = 0; s < results->scenes; s++) {
        dl_results_answer(results, results->scene[s].name, answer, sizeof answer);
        if (*answer)
            fprintf(out, "%s\n", answer);
    }
    if (results->scenes > 1 && !dl_study_kind_of(results)->print) {
        char all[4 * DL_MESSAGE_SIZE];
        dl_results_answer_all(&results, 1, all, sizeof all);
        fprintf(out, "%s\n", all);
    }
}
