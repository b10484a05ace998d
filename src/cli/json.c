#include "cli/json.h"

#include <math.h>

json_t *cli_json_real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_value(const dl_parameter *row, const void *object) {
    const void *at = (const char *)object + row->offset;
    switch (row->kind) {
    case DL_REAL:
        return cli_json_real(*(const double *)at);
    case DL_INTEGER:
        return json_integer(*(const long *)at);
    case DL_FLAG:
        return json_boolean(*(const bool *)at);
    case DL_WORD:
        return json_string(row->words[*(const int *)at]);
    case DL_TEXT:
        break;
    }
    const char *text = *(char *const *)at;
    return text ? json_string(text) : json_null();
}

dl_status cli_json_print(json_t *root, FILE *out, dl_error *error) {
    if (!root)
        return dl_fail_memory(error, "JSON");
    const int failed = json_dumpf(root, out, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(root);
    return failed || fputc('\n', out) == EOF
               ? dl_fail(error, DL_IO, "standard output cannot be written")
               : DL_OK;
}
