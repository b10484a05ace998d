/* How a kind of study fills a finding (results.h), and how it travels from child to parent. */
#ifndef DL_STUDY_FINDING_H
#define DL_STUDY_FINDING_H

#include "driftlab/results.h"

/* Empty texts, no quantities, no table. Freed with dl_finding_release, on failure too. */
dl_status dl_finding_create(dl_finding *finding, dl_error *error);

/* Appends a quantity, "NAME" or "NAME [UNIT]". low, high: interval of confidence, or NAN. */
dl_status dl_finding_add(dl_finding *finding, const char *name, double value, double low,
                         double high, dl_error *error);

/* Names the columns, a line each, before the first row. */
dl_status dl_finding_set_columns(dl_finding *finding, const char *names, dl_error *error);
/* Appends a row of as many values as there are columns; `word` is one line, or "". */
dl_status dl_finding_add_row(dl_finding *finding, const double *values, const char *word,
                             dl_error *error);

/* Verdict, and the reason as a format. */
dl_status dl_finding_judge(dl_finding *finding, dl_error *error, const char *verdict,
                           const char *reason, ...) __attribute__((format(printf, 4, 5)));

/* What runs are made finer by, among the options: "step=0.01", or "rtol=1e-06" where the method
 * chooses its steps; "" where there is neither. */
void dl_options_fineness(const char *options, char *text, size_t size);
void dl_finding_fineness(const dl_finding *finding, char *text, size_t size);

/* The finding as bytes of its own, and back (a finding that is to be released on failure too). */
dl_status dl_finding_pack(const dl_finding *finding, void **bytes, size_t *size, dl_error *error);
dl_status dl_finding_unpack(const void *bytes, size_t size, dl_finding *finding, dl_error *error);

#endif
