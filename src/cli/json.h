/* What jansson does not have: reals that may not be numbers, and values of parameter tables. */
#ifndef DL_CLI_JSON_H
#define DL_CLI_JSON_H

#include <jansson.h>
#include <stdio.h>
#include "driftlab/parameter.h"

/* null where `value` is not finite. */
json_t *cli_json_real(double value);

/* The value that `row` describes in `object`, in its own JSON type. */
json_t *cli_json_value(const dl_parameter *row, const void *object);

/* Prints `root` with 17 digits and a newline, and releases it. NULL: out of memory. */
dl_status cli_json_print(json_t *root, FILE *out, dl_error *error);

#endif
