/* Where results come from: program, compiler, libraries, machine, date, command. */
#ifndef DL_STUDY_FACTS_H
#define DL_STUDY_FACTS_H

#include "driftlab/results.h"

/* command: NULL where there is none. */
dl_status dl_facts_add(dl_results *results, const char *command, dl_error *error);

/* Names of the facts without which CPU times cannot be compared; NULL-terminated. */
extern const char *const dl_facts_of_timing[];

#endif
