/* CPU time of this process, threads of kernels included, as one interval or the sum of several. */
#ifndef DL_OBSERVE_STOPWATCH_H
#define DL_OBSERVE_STOPWATCH_H

/* Seconds; only differences mean anything. */
double dl_cpu_clock(void);

typedef struct dl_stopwatch {
    double total;   /* of the intervals that have ended */
    double started; /* of the one under way */
} dl_stopwatch;

void dl_stopwatch_start(dl_stopwatch *watch);
void dl_stopwatch_stop(dl_stopwatch *watch);

#endif
