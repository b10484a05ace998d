/* What makes a case the same case: its scene's content, its method, every option, how far it runs
 * and what it is measured against. Limits and repeats are not part of it. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "study/kind.h"

char *dl_text(const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    char *text = length < 0 ? NULL : malloc((size_t)length + 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    return text;
}

/* FNV-1a, 64 bits (http://www.isthe.com/chongo/tech/comp/fnv/). */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size) {
    const unsigned char *byte = data;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static const uint64_t hash_start = UINT64_C(0xcbf29ce484222325);

uint64_t dl_scene_hash(const dl_scene *scene) {
    size_t n = scene->particles, vector = (size_t)scene->dimension * n * sizeof(double);
    uint64_t hash = hash_bytes(hash_start, scene->text, strlen(scene->text));
    hash = hash_bytes(hash, scene->position, vector);
    hash = hash_bytes(hash, scene->velocity, vector);
    hash = hash_bytes(hash, scene->inertia, n * sizeof *scene->inertia);
    hash = hash_bytes(hash, scene->coupling, n * sizeof *scene->coupling);
    if (scene->species > 0) /* a data file may tell them */
        hash = hash_bytes(hash, scene->species_of, n * sizeof *scene->species_of);
    hash = hash_bytes(hash, scene->feels_gravity, n * sizeof *scene->feels_gravity);
    return hash_bytes(hash, scene->pinned, n * sizeof *scene->pinned);
}

/* Of the extended integrator: to be raised when what it computes changes. */
static const int extended_version = 1;

char *dl_study_reference_key(const dl_study *study, const dl_study_scene *on) {
    char end[40];
    dl_format_real(on->end, end, sizeof end);
    const dl_study_run_of *run = &on->reference, *check = &on->check;
    if (study->reference == DL_REFERENCE_EXACT)
        return dl_text("%s#%016llx exact kepler end=%s samples=%ld", on->scene->name,
                       (unsigned long long)on->hash, end, study->settings.samples);
    if (study->reference == DL_REFERENCE_EXTENDED)
        return dl_text("%s#%016llx extended-%d %s end=%s samples=%ld", on->scene->name,
                       (unsigned long long)on->hash, extended_version,
                       dl_precision_words[study->precision], end, study->settings.samples);
    return dl_text("%s#%016llx %s %s, check %s %s end=%s samples=%ld", on->scene->name,
                   (unsigned long long)on->hash, run->row->name, run->text, check->row->name,
                   check->text, end, study->settings.samples);
}

static uint64_t hash_text(uint64_t hash, const char *text) {
    return text ? hash_bytes(hash, text, strlen(text)) : hash;
}

static uint64_t hash_reals(uint64_t hash, const double *values, size_t count) {
    return values ? hash_bytes(hash, values, count * sizeof *values) : hash;
}

char *dl_reference_digest(const dl_reference *reference) {
    const double numbers[] = {reference->error,    reference->seconds, reference->length,
                              reference->lyapunov, reference->parted,  reference->lyapunov_error,
                              reference->horizon};
    const size_t positions =
        reference->samples * (size_t)reference->dimension * reference->particles;
    uint64_t hash = hash_text(hash_start, reference->key);
    hash = hash_text(hash, reference->scene);
    hash = hash_text(hash, reference->description);
    hash = hash_text(hash, reference->precision);
    hash = hash_text(hash, reference->note);
    hash = hash_reals(hash, numbers, sizeof numbers / sizeof *numbers);
    hash = hash_reals(hash, reference->time, reference->samples);
    hash = hash_reals(hash, reference->sample_error, reference->samples);
    hash = hash_reals(hash, reference->growth, reference->samples);
    hash = hash_reals(hash, reference->position, positions);
    hash = hash_reals(hash, reference->position_low, positions);
    return dl_text("%016llx", (unsigned long long)hash);
}

char *dl_study_case_key(const dl_study *study, const dl_study_case *cased) {
    const dl_study_scene *on = &study->scene[cased->scene];
    char end[40], reference[40] = "";
    dl_format_real(on->end, end, sizeof end);
    if (on->reference_key) {
        uint64_t hash = hash_bytes(hash_start, on->reference_key, strlen(on->reference_key));
        snprintf(reference, sizeof reference, " reference=%016llx", (unsigned long long)hash);
    }
    if (study->kind->measure)
        return dl_text("%s(%s) %s#%016llx %s %s end=%s samples=%ld",
                       dl_study_kinds[study->settings.kind], study->kind_text, on->scene->name,
                       (unsigned long long)on->hash, cased->run.row->name, cased->run.text, end,
                       study->settings.samples);
    return dl_text("%s#%016llx %s %s end=%s samples=%ld%s", on->scene->name,
                   (unsigned long long)on->hash, cased->run.row->name, cased->run.text, end,
                   study->settings.samples, reference);
}

uint64_t dl_study_hash(const dl_study *study) {
    uint64_t hash = hash_start;
    for (size_t i = 0; i < study->scenes; i++)
        hash = hash_text(hash, study->scene[i].reference_key);
    for (size_t i = 0; i < study->cases; i++)
        hash = hash_text(hash, study->cased[i].key);
    return hash;
}

/* Quotes for the shell where a path needs them. */
static char *shell_word(const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "/._-+=:,@%";
    if (*word && word[strspn(word, plain)] == '\0')
        return dl_text("%s", word);
    char *quoted = malloc(4 * strlen(word) + 3), *to = quoted;
    if (!quoted)
        return NULL;
    *to++ = '\'';
    for (; *word; word++) {
        if (*word == '\'') {
            memcpy(to, "'\\''", 4);
            to += 4;
        } else {
            *to++ = *word;
        }
    }
    *to++ = '\'';
    *to = '\0';
    return quoted;
}

/* `measure` chooses the same samples where nobody asks for any. */
char *dl_study_case_command(const dl_study *study, const dl_study_case *cased) {
    const dl_study_scene *on = &study->scene[cased->scene];
    char end[40], sample[40], asked[64] = "";
    dl_format_real(on->end, end, sizeof end);
    dl_format_real(on->sample, sample, sizeof sample);
    if (!study->kind->measure || !on->sample_chosen)
        snprintf(asked, sizeof asked, " --sample %s", sample);
    char *path = shell_word(on->path);
    char *verb = study->kind->measure ? dl_text("measure %s", dl_study_kinds[study->settings.kind])
                                      : dl_text("run");
    char *command = path && verb ? dl_text("driftlab %s %s%s --method %s%s%s --t-end %s%s", verb,
                                           path, on->lets ? on->lets : "", cased->run.row->name,
                                           cased->run.changes, study->kind_changes, end, asked)
                                 : NULL;
    free(verb);
    free(path);
    return command;
}
