/* Which program wrote a results file, for the message that another cannot read it. */
#ifndef DL_IO_RESULTS_ORIGIN_H
#define DL_IO_RESULTS_ORIGIN_H

#include <hdf5.h>
#include "driftlab/status.h"

/* DL_INPUT: the file at `path`, of format `version`, has no `lacking` ("cases/0003/steps"; "": it
 * is of a format that is not known here). Names the program that wrote it, this one, and what to
 * do. */
dl_status dl_results_fail_other_program(const char *path, hid_t file, int version,
                                        const char *lacking, dl_error *error);

#endif
