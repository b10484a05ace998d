#include "driftlab/parameter.h"

#include <errno.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { longest_word = 63, shown_bytes = 60, quoted_size = shown_bytes + 8 };

/* --- closest match ---------------------------------------------------------------------------- */

/* Case and the choice of separator are no difference between words. */
static char folded(char c) {
    if (c >= 'A' && c <= 'Z')
        return (char)(c - 'A' + 'a');
    return c == '_' || c == ' ' ? '-' : c;
}

static size_t smaller(size_t a, size_t b) {
    return a < b ? a : b;
}

/* Insertions, deletions, substitutions and swaps of neighbours that turn one word into the other
 * (optimal string alignment). Both at most longest_word characters. */
static size_t edit_distance(const char *from, const char *to) {
    size_t rows[3][longest_word + 1];
    size_t *above2 = rows[0], *above = rows[1], *row = rows[2];
    const size_t columns = strlen(to);
    for (size_t j = 0; j <= columns; j++)
        above[j] = j;
    for (size_t i = 1; from[i - 1]; i++) {
        row[0] = i;
        for (size_t j = 1; j <= columns; j++) {
            const char a = folded(from[i - 1]), b = folded(to[j - 1]);
            row[j] = smaller(above[j - 1] + (a != b), smaller(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a == folded(to[j - 2]) && folded(from[i - 2]) == b)
                row[j] = smaller(row[j], above2[j - 2] + 1);
        }
        size_t *const free_row = above2;
        above2 = above;
        above = row;
        row = free_row;
    }
    return above[columns];
}

/* The nearest word so far. */
typedef struct search {
    const char *wanted;
    const char *word;
    size_t distance;
} search;

/* A third of the longer word may differ; failing that, one word may be a part of the other. */
static void consider(search *best, const char *word) {
    const size_t length = strlen(word), wanted_length = strlen(best->wanted);
    if (length > longest_word || wanted_length > longest_word)
        return;
    const size_t longer = length > wanted_length ? length : wanted_length;
    size_t distance = edit_distance(best->wanted, word);
    if (distance > (longer + 1) / 3 || distance >= longer) {
        const bool part = smaller(length, wanted_length) >= 3 &&
                          (strstr(word, best->wanted) || strstr(best->wanted, word));
        if (!part)
            return;
        distance += longest_word; /* after every match by distance */
    }
    if (!best->word || distance < best->distance) {
        best->word = word;
        best->distance = distance;
    }
}

const char *dl_parameter_closest(dl_parameter_table table, const char *name) {
    search best = {.wanted = name};
    for (size_t i = 0; i < table.count; i++)
        consider(&best, table.rows[i].name);
    return best.word;
}

const char *dl_closest_word(const char *const *words, const char *word) {
    search best = {.wanted = word};
    for (; *words; words++)
        consider(&best, *words);
    return best.word;
}

const dl_parameter *dl_parameter_find(dl_parameter_table table, const char *name) {
    for (size_t i = 0; i < table.count; i++)
        if (strcmp(table.rows[i].name, name) == 0)
            return &table.rows[i];
    return NULL;
}

/* --- text of values --------------------------------------------------------------------------- */

/* Bytes of the UTF-8 character at `text`; 0 where there is none. */
static size_t character_length(const unsigned char *text) {
    const unsigned char lead = text[0];
    if (lead < 0x80)
        return lead >= 0x20 && lead != 0x7f;
    const size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    const bool overlong = (lead == 0xe0 && text[1] < 0xa0) || (lead == 0xf0 && text[1] < 0x90);
    const bool no_code_point =
        (lead == 0xed && text[1] >= 0xa0) || (lead == 0xf4 && text[1] >= 0x90);
    if (lead < 0xc2 || lead > 0xf4 || overlong || no_code_point)
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((text[i] & 0xc0) != 0x80)
            return 0;
    return length;
}

int dl_quote(const char *value, char *text, size_t size) {
    char shown[quoted_size];
    size_t used = 0;
    const unsigned char *at = (const unsigned char *)value;
    while (*at && used + 4 <= shown_bytes) {
        const size_t length = character_length(at);
        if (length == 0) {
            shown[used++] = '?';
            at++;
            continue;
        }
        memcpy(shown + used, at, length);
        used += length;
        at += length;
    }
    shown[used] = '\0';
    return snprintf(text, size, "\"%s%s\"", shown, *at ? "..." : "");
}

int dl_format_real(double value, char *text, size_t size) {
    /* 15 digits give back every decimal of at most 15 digits; subnormal numbers carry fewer. */
    char shortest[40];
    for (int digits = fabs(value) < DBL_MIN ? 1 : 15; digits <= 17; digits++) {
        snprintf(shortest, sizeof shortest, "%.*g", digits, value);
        if (strtod(shortest, NULL) == value)
            break;
    }
    return snprintf(text, size, "%s", shortest);
}

static bool none_allowed(const dl_parameter *row) {
    return row->kind == DL_REAL && row->fallback && strcmp(row->fallback, "none") == 0;
}

int dl_parameter_format(const dl_parameter *row, const void *object, char *text, size_t size) {
    const char *const at = (const char *)object + row->offset;
    switch (row->kind) {
    case DL_REAL: {
        const double value = *(const double *)(const void *)at;
        if (isinf(value) && none_allowed(row))
            return snprintf(text, size, "none");
        return dl_format_real(value, text, size);
    }
    case DL_INTEGER:
        return snprintf(text, size, "%ld", *(const long *)(const void *)at);
    case DL_FLAG:
        return snprintf(text, size, "%s", *(const bool *)(const void *)at ? "true" : "false");
    case DL_WORD:
        return snprintf(text, size, "%s", row->words[*(const int *)(const void *)at]);
    case DL_TEXT: {
        const char *const value = *(char *const *)(const void *)at;
        return snprintf(text, size, "%s", value ? value : "");
    }
    }
    return snprintf(text, size, "%s", "");
}

/* --- what is allowed -------------------------------------------------------------------------- */

/* Appends to text as far as it fits; `used` counts what a large enough text would hold. */
static void append(char *text, size_t size, int *used, const char *before, const char *word) {
    const size_t at = (size_t)*used;
    *used +=
        snprintf(at < size ? text + at : NULL, at < size ? size - at : 0, "%s%s", before, word);
}

static bool unbounded(const dl_parameter *row, double limit) {
    return row->kind == DL_INTEGER ? fabs(limit) >= (double)LONG_MAX : fabs(limit) >= DBL_MAX;
}

static int number_range(const dl_parameter *row, char *text, size_t size) {
    char number[40];
    int used = 0;
    if (!unbounded(row, row->minimum)) {
        dl_format_real(row->minimum, number, sizeof number);
        append(text, size, &used, row->above_minimum ? "> " : ">= ", number);
    }
    if (!unbounded(row, row->maximum)) {
        dl_format_real(row->maximum, number, sizeof number);
        append(text, size, &used, used ? ", <= " : "<= ", number);
    }
    if (used == 0)
        append(text, size, &used, "", row->kind == DL_REAL ? "a number" : "a whole number");
    if (none_allowed(row))
        append(text, size, &used, ", ", "or none");
    return used;
}

int dl_parameter_range(const dl_parameter *row, char *text, size_t size) {
    if (row->kind == DL_FLAG)
        return snprintf(text, size, "true | false");
    if (row->kind == DL_TEXT)
        return snprintf(text, size, "text");
    if (row->kind != DL_WORD)
        return number_range(row, text, size);
    int used = 0;
    for (const char *const *word = row->words; *word; word++)
        append(text, size, &used, word == row->words ? "" : " | ", *word);
    return used;
}

static dl_status refuse(const dl_parameter *row, const char *value, dl_error *error) {
    char range[1024], shown[quoted_size];
    dl_parameter_range(row, range, sizeof range);
    dl_quote(value, shown, sizeof shown);
    const char *noun = "";
    if ((row->kind == DL_REAL || row->kind == DL_INTEGER) && strchr("<>", range[0]))
        noun = row->kind == DL_REAL ? "a number " : "a whole number ";
    const char *const closest = row->kind == DL_WORD ? dl_closest_word(row->words, value) : NULL;
    if (closest)
        return dl_fail(error, DL_INPUT, "%s: found %s, expected %s; did you mean \"%s\"?",
                       row->name, shown, range, closest);
    return dl_fail(error, DL_INPUT, "%s: found %s, expected %s%s", row->name, shown, noun, range);
}

/* --- text to value ---------------------------------------------------------------------------- */

static bool in_range(const dl_parameter *row, double value) {
    const bool high_enough = row->above_minimum ? value > row->minimum : value >= row->minimum;
    return high_enough && value <= row->maximum;
}

static bool set_real(const dl_parameter *row, void *at, const char *text) {
    double value = INFINITY;
    if (!(none_allowed(row) && strcmp(text, "none") == 0)) {
        /* strtod takes more than a scene may say: blanks, nan, inf, hexadecimal. */
        if (text[0] == '\0' || text[strspn(text, "0123456789+-.eE")] != '\0')
            return false;
        char *end;
        value = strtod(text, &end);
        if (*end || !isfinite(value) || !in_range(row, value))
            return false;
    }
    *(double *)at = value;
    return true;
}

static bool set_integer(const dl_parameter *row, void *at, const char *text) {
    if (text[0] == '\0' || text[strspn(text, "0123456789+-")] != '\0')
        return false;
    char *end;
    errno = 0;
    const long value = strtol(text, &end, 10);
    if (*end || errno || !in_range(row, (double)value))
        return false;
    *(long *)at = value;
    return true;
}

static bool set_flag(const dl_parameter *row, void *at, const char *text) {
    (void)row;
    const bool value = strcmp(text, "true") == 0;
    if (!value && strcmp(text, "false") != 0)
        return false;
    *(bool *)at = value;
    return true;
}

static bool set_word(const dl_parameter *row, void *at, const char *text) {
    for (int i = 0; row->words[i]; i++) {
        if (strcmp(row->words[i], text) == 0) {
            *(int *)at = i;
            return true;
        }
    }
    return false;
}

static dl_status set_text(const dl_parameter *row, char **at, const char *text, dl_error *error) {
    char *const copy = strdup(text);
    if (!copy)
        return dl_fail_memory(error, row->name);
    free(*at);
    *at = copy;
    return DL_OK;
}

static bool (*const setters[])(const dl_parameter *row, void *at, const char *text) = {
    [DL_REAL] = set_real,
    [DL_INTEGER] = set_integer,
    [DL_FLAG] = set_flag,
    [DL_WORD] = set_word,
};

dl_status dl_parameter_set(const dl_parameter *row, void *object, const char *value,
                           dl_error *error) {
    void *const at = (char *)object + row->offset;
    if (row->kind == DL_TEXT)
        return set_text(row, at, value, error);
    return setters[row->kind](row, at, value) ? DL_OK : refuse(row, value, error);
}

dl_status dl_parameter_defaults(dl_parameter_table table, void *object, dl_error *error) {
    for (size_t i = 0; i < table.count; i++) {
        const dl_parameter *const row = &table.rows[i];
        const dl_status status =
            row->fallback ? dl_parameter_set(row, object, row->fallback, error) : DL_OK;
        if (status)
            return status;
    }
    return DL_OK;
}

/* --- which are used --------------------------------------------------------------------------- */

/* Whether `value` is one of the words that `list` holds, with | between them. */
static bool is_listed(const char *list, const char *value) {
    const size_t length = strlen(value);
    for (const char *word = list;; word += strcspn(word, "|") + 1) {
        if (strcspn(word, "|") == length && strncmp(word, value, length) == 0)
            return true;
        if (word[strcspn(word, "|")] == '\0')
            return false;
    }
}

const dl_parameter *dl_parameter_cause(dl_parameter_table table, const dl_parameter *row) {
    if (!row->when)
        return NULL;
    char name[longest_word + 1];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(row->when, "="), row->when);
    return dl_parameter_find(table, name);
}

bool dl_parameter_applies(dl_parameter_table table, const dl_parameter *row, const void *object) {
    const dl_parameter *const cause = dl_parameter_cause(table, row);
    if (!cause)
        return true;
    char value[longest_word + 1];
    dl_parameter_format(cause, object, value, sizeof value);
    return is_listed(strchr(row->when, '=') + 1, value) &&
           dl_parameter_applies(table, cause, object);
}

void dl_parameter_release(dl_parameter_table table, void *object) {
    for (size_t i = 0; i < table.count; i++) {
        if (table.rows[i].kind != DL_TEXT)
            continue;
        char **const at = (char **)(void *)((char *)object + table.rows[i].offset);
        free(*at);
        *at = NULL;
    }
}
