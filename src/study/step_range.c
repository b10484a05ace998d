#include "study/step_range.h"

const char *const dl_step_units[] = {
    [DL_OF_FREQUENCY] = "frequency", [DL_OF_STEP] = "step", [DL_OF_TIME] = "time", NULL};

dl_status dl_step_range_check(const dl_step_range *range, dl_error *error) {
    return range->smallest <= range->largest
               ? DL_OK
               : dl_fail(error, DL_INPUT, "smallest: found %g, expected at most largest, %g",
                         range->smallest, range->largest);
}

double dl_step_range_unit(const dl_step_range *range, double step, double omega) {
    const double units[] = {
        [DL_OF_FREQUENCY] = omega > 0 ? 2 / omega : step, [DL_OF_STEP] = step, [DL_OF_TIME] = 1};
    return units[range->unit];
}
