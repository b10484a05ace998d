/* Where the studies that come with the program lie. */
#ifndef DL_CLI_STUDIES_H
#define DL_CLI_STUDIES_H

#include <stddef.h>
#include "driftlab/status.h"

/* Their folder: `asked` (--studies; NULL: not given), or else ./studies, or else the installed one.
 */
dl_status cli_find_studies(const char *asked, char *studies, size_t size, dl_error *error);

#endif
