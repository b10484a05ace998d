#include "io/results_origin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/version.h"
#include "io/results_schema.h"
#include "source_hash.h"

enum { WORD_SIZE = 64 };

/* An attribute of fixed length, cut to a word; "" where there is none. */
static void read_word(hid_t owner, const char *name, char word[WORD_SIZE]) {
    word[0] = '\0';
    hid_t attribute = H5Aopen(owner, name, H5P_DEFAULT);
    if (attribute < 0)
        return;
    hid_t type = H5Aget_type(attribute);
    if (H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0) {
        char *text = calloc(H5Tget_size(type) + 1, 1);
        if (text && H5Aread(attribute, type, text) >= 0)
            snprintf(word, WORD_SIZE, "%.*s", WORD_SIZE - 1, text);
        free(text);
    }
    H5Tclose(type);
    H5Aclose(attribute);
}

/* The value of the fact of that name, or "unknown". Names of facts are older than any change of the
 * format. */
static void read_fact(hid_t file, const char *name, char value[WORD_SIZE]) {
    char at[WORD_SIZE], found[WORD_SIZE];
    snprintf(value, WORD_SIZE, "unknown");
    for (unsigned i = 0;; i++) {
        snprintf(at, sizeof at, "facts/%04u", i);
        if (H5Lexists(file, "facts", H5P_DEFAULT) <= 0 || H5Lexists(file, at, H5P_DEFAULT) <= 0)
            return;
        hid_t fact = H5Gopen2(file, at, H5P_DEFAULT);
        if (fact < 0)
            return;
        read_word(fact, "name", found);
        const bool is_it = strcmp(found, name) == 0;
        if (is_it)
            read_word(fact, "value", value);
        H5Gclose(fact);
        if (is_it)
            return;
    }
}

dl_status dl_results_fail_other_program(const char *path, hid_t file, int version,
                                        const char *lacking, dl_error *error) {
    char program[WORD_SIZE], source[WORD_SIZE];
    read_fact(file, "driftlab", program);
    read_fact(file, "source", source);
    if (*lacking && strcmp(source, DL_SOURCE_HASH) == 0)
        return dl_fail(error, DL_INPUT,
                       "%s: damaged: found no %s, expected a whole results file of this program; "
                       "run its study again into a new file (driftlab study STUDY.yaml --out "
                       "NEW.h5)",
                       path, lacking);
    return dl_fail(error, DL_INPUT,
                   "%s: found a results file of format version %d, by driftlab %s (source %s)%s%s; "
                   "expected format version %d, as of this driftlab %s (source %s): read it with "
                   "the program that wrote it, or run its study with this one into a new file "
                   "(driftlab study STUDY.yaml --out NEW.h5)",
                   path, version, program, source, *lacking ? ", which has no " : "", lacking,
                   DL_RESULTS_VERSION, dl_version(), DL_SOURCE_HASH);
}
