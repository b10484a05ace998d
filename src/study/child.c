#include "study/child.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "study/message.h"
#include "study/process.h"

/* --- the child ----------------------------------------------------------------------------- */

void dl_child_send(int pipe, const void *data, size_t size) {
    if (!dl_message_send(pipe, data, size))
        _exit(EXIT_FAILURE);
}

static void limit(int resource, rlim_t value) {
    struct rlimit found;
    if (getrlimit(resource, &found) == 0) {
        found.rlim_cur = value < found.rlim_max ? value : found.rlim_max;
        setrlimit(resource, &found); /* a limit that cannot be set is not worth failing for */
    }
}

static void limit_memory(long mebibytes) {
#ifdef DL_SANITIZED
    (void)mebibytes; /* the sanitizers reserve terabytes of address space */
#else
    limit(RLIMIT_AS, (rlim_t)mebibytes << 20);
#endif
}

static void prepare_child(const dl_child_work *work, pid_t parent) {
    dl_process_end_with(parent);
    /* Control-C at a terminal reaches the child too: the parent decides what ends it. */
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    limit(RLIMIT_CORE, 0);
    /* No RLIMIT_CPU: with it, Linux gives a process's CPU time in whole ticks (measured: 4 ms),
     * which would be the resolution of every case's time. The parent watches the clocks. */
    if (work->memory > 0)
        limit_memory(work->memory);
    dl_process_stay_here(); /* caches and clock stay the same during a case */
}

/* --- the parent ---------------------------------------------------------------------------- */

typedef struct parent {
    const dl_child_work *work;
    pid_t child;
    dl_message message;
    double heard_cpu, heard_wall; /* clocks at the last message */
} parent;

static double seconds_of(clockid_t clock) {
    struct timespec time = {0};
    clock_gettime(clock, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* CPU time that the child has used; that of one which has ended does not count. */
static double cpu_of_child(const parent *from) {
    clockid_t clock;
    return clock_getcpuclockid(from->child, &clock) == 0 ? seconds_of(clock) : 0;
}

static void start_clocks(parent *from) {
    from->heard_cpu = cpu_of_child(from);
    from->heard_wall = seconds_of(CLOCK_MONOTONIC);
}

/* The run's own limit comes first; a run that is deaf to it meets this one. The wall clock is for a
 * child that waits for something, and leaves room for a busy machine. */
static dl_status check_clocks(const parent *from, dl_error *error) {
    const double limit = from->work->seconds;
    const double cpu = cpu_of_child(from) - from->heard_cpu;
    const double wall = seconds_of(CLOCK_MONOTONIC) - from->heard_wall;
    if (cpu <= 2 * limit + 1 && wall <= 20 * limit + 60)
        return DL_OK;
    return dl_fail(error, DL_TIMEOUT,
                   "killed after %.3g CPU seconds (%.3g s by the clock) without an answer; the "
                   "limit is %g CPU seconds a run",
                   cpu, wall, limit);
}

/* Reads what there is; *ended where the child has closed its end. */
static dl_status take(parent *from, bool *ended, dl_error *error) {
    bool whole;
    dl_status status = dl_message_take(&from->message, &whole, ended, error);
    if (status != DL_OK || !whole)
        return status;
    status = from->work->receive(from->work->context, dl_message_bytes(&from->message),
                                 dl_message_size(&from->message), error);
    start_clocks(from);
    return status;
}

static dl_status listen_to(parent *from, dl_error *error) {
    const dl_child_work *work = from->work;
    dl_status status = DL_OK;
    bool ended = false;
    while (status == DL_OK && !ended) {
        struct pollfd wait = {.fd = from->message.pipe, .events = POLLIN};
        int ready = poll(&wait, 1, 200);
        if (work->tick)
            work->tick(work->context);
        if (work->interrupt && *work->interrupt)
            return dl_fail(error, DL_INTERRUPTED, "interrupted");
        if (ready > 0)
            status = take(from, &ended, error);
        else
            status = check_clocks(from, error);
    }
    return status;
}

static const struct {
    int number;
    const char *name;
} signals[] = {
    {SIGSEGV, "SIGSEGV (invalid memory access)"},
    {SIGABRT, "SIGABRT (abort)"},
    {SIGFPE, "SIGFPE (arithmetic)"},
    {SIGILL, "SIGILL (illegal instruction)"},
    {SIGBUS, "SIGBUS (bus error)"},
    {SIGKILL, "SIGKILL (killed, perhaps for want of memory)"},
    {SIGTERM, "SIGTERM (terminated)"},
};

static dl_status judge_exit(int exit_status, dl_error *error) {
    if (WIFEXITED(exit_status)) {
        int code = WEXITSTATUS(exit_status);
        return code == 0 ? DL_OK
                         : dl_fail(error, DL_ERROR, "its process ended with exit status %d", code);
    }
    int number = WTERMSIG(exit_status);
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        if (signals[i].number == number)
            return dl_fail(error, DL_ERROR, "its process was ended by %s", signals[i].name);
    return dl_fail(error, DL_ERROR, "its process was ended by signal %d", number);
}

static dl_status wait_for(pid_t child, dl_error *error) {
    int exit_status = 0;
    while (waitpid(child, &exit_status, 0) < 0)
        if (errno != EINTR)
            return dl_fail(error, DL_IO, "waiting for a case's process: %s", strerror(errno));
    return judge_exit(exit_status, error);
}

dl_status dl_child_run(const dl_child_work *work, dl_error *error) {
    int ends[2];
    if (pipe(ends))
        return dl_fail(error, DL_IO, "a pipe for a case: %s", strerror(errno));
    pid_t self = getpid(), child = fork();
    if (child < 0) {
        close(ends[0]);
        close(ends[1]);
        return dl_fail(error, DL_IO, "a process for a case: %s", strerror(errno));
    }
    if (child == 0) {
        close(ends[0]);
        prepare_child(work, self);
        work->work(work->context, ends[1]);
        _exit(EXIT_SUCCESS);
    }
    close(ends[1]);
    parent from = {.work = work, .child = child, .message = {.pipe = ends[0]}};
    start_clocks(&from);
    dl_status status = listen_to(&from, error);
    if (status != DL_OK)
        kill(child, SIGKILL);
    dl_status ended = wait_for(child, status == DL_OK ? error : NULL);
    close(ends[0]);
    free(from.message.data);
    return status == DL_OK ? ended : status;
}
