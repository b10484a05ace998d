#include "methods/options.h"

#include <string.h>

static bool is_default(const dl_method *method, const char *name) {
    const dl_parameter *const option = dl_parameter_find(method->row->options, name);
    double fallback = 0;
    dl_parameter alone = *option;
    alone.offset = 0;
    dl_parameter_set(&alone, &fallback, option->fallback, NULL);
    const char *const at = (const char *)method->options + option->offset;
    double value;
    memcpy(&value, at, sizeof value);
    return value == fallback;
}

dl_status dl_method_refuse_unused_tolerances(const dl_method *method, double step,
                                             dl_error *error) {
    if (!(step > 0) || (is_default(method, "rtol") && is_default(method, "atol")))
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "method %s: step = %g is a fixed step, which rtol and atol do not change; give "
                   "either step or tolerances",
                   method->row->name, step);
}
