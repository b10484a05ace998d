#ifdef __linux__
#define _GNU_SOURCE /* sched_setaffinity */
#include <sched.h>
#include <sys/prctl.h>
#endif
#include "study/process.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

void dl_process_end_with(pid_t parent) {
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (getppid() != parent)
        _exit(EXIT_FAILURE);
}

size_t dl_process_processors(void) {
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        return (size_t)CPU_COUNT(&set);
#endif
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (size_t)online : 1;
}

#ifdef __linux__
static void stay_on_number(size_t processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    sched_setaffinity(0, sizeof set, &set);
}
#endif

void dl_process_stay_here(void) {
#ifdef __linux__
    const int here = sched_getcpu();
    if (here >= 0 && here < CPU_SETSIZE)
        stay_on_number((size_t)here);
#endif
}

void dl_process_stay_on(size_t index) {
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set))
        return;
    for (size_t processor = 0; processor < CPU_SETSIZE; processor++)
        if (CPU_ISSET(processor, &set) && index-- == 0) {
            stay_on_number(processor);
            return;
        }
#else
    (void)index;
#endif
}
