/* What a study is made of: cases, or the units of another kind (kind.h). Here they are one thing:
 * an element of the results with a key, which is measured, kept, sent, sorted in the same way. */
#ifndef DL_STUDY_PARTS_H
#define DL_STUDY_PARTS_H

#include "study/kind.h"

typedef union dl_study_part {
    dl_case cased;
    dl_finding finding;
} dl_study_part;

/* Whether the results hold it. */
bool dl_part_is_done(const dl_study *study, const dl_results *results, size_t part);

/* "stream: leapfrog step=0.01"; NULL: no memory. */
char *dl_part_label(const dl_study *study, size_t part);

/* As dl_study_measure_case or dl_study_measure_unit, which say when it fails. The references are in
 * `results`. */
dl_status dl_part_measure(const dl_study *study, const dl_results *results, size_t part,
                          const dl_watch *watch, void (*heard)(void *context, const char *),
                          void *heard_context, dl_study_part *measured, dl_error *error);
void dl_part_release(const dl_study *study, dl_study_part *part);

/* Appends it to the results, which own it then; on failure it is released. */
dl_status dl_part_add(const dl_study *study, dl_results *results, dl_study_part *part,
                      dl_error *error);

/* For another process, and back. */
dl_status dl_part_pack(const dl_study *study, const dl_study_part *part, void **bytes, size_t *size,
                       dl_error *error);
dl_status dl_part_unpack(const dl_study *study, const void *bytes, size_t size, dl_study_part *part,
                         dl_error *error);

/* In a process that works for another: measures it, and sends it or why it could not be. */
void dl_part_measure_and_send(const dl_study *study, const dl_results *results, size_t part,
                              const dl_watch *watch, int pipe);
/* In the other: what was sent. A failure is the sender's, or the message's. */
dl_status dl_part_receive(const dl_study *study, const void *data, size_t size,
                          dl_study_part *measured, dl_error *error);

/* Moves out of the old results what this study asks for. */
dl_status dl_parts_keep(const dl_study *study, dl_results *old, dl_results *results,
                        dl_error *error);

/* In the order of the study, wherever they were measured. All are there. */
dl_status dl_parts_sort(const dl_study *study, dl_results *results, dl_error *error);

#endif
