#include "observe/stopwatch.h"

#include <time.h>

double dl_cpu_clock(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void dl_stopwatch_start(dl_stopwatch *watch) {
    watch->started = dl_cpu_clock();
}

void dl_stopwatch_stop(dl_stopwatch *watch) {
    watch->total += dl_cpu_clock() - watch->started;
}
