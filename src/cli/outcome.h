/* From a status to the program's exit status. */
#ifndef DL_CLI_OUTCOME_H
#define DL_CLI_OUTCOME_H

#include "cli/command.h"
#include "driftlab/status.h"

cli_exit cli_exit_of(dl_status status);

/* Complains where `status` is not DL_OK; returns its exit status. */
cli_exit cli_finish(dl_status status, const dl_error *error);

#endif
