#include "study/lanes.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "study/message.h"
#include "study/process.h"

enum { IDLE = -1 };

typedef struct lane {
    pid_t child; /* 0: none of this process's */
    int orders;  /* the parent writes the next part's number there; -1: lost, or never started */
    long part;   /* that it does, or IDLE */
    dl_message message;
} lane;

typedef struct lanes {
    const dl_lanes_work *work;
    size_t count, parts, next;
    bool *done;
    lane *lane;
    struct pollfd *wait;
} lanes;

/* --- a lane -------------------------------------------------------------------------------- */

static void serve(const dl_lanes_work *work, int orders, int answers) {
    dl_message order = {.pipe = orders};
    bool whole = false, ended = false;
    while (dl_message_take(&order, &whole, &ended, NULL) == DL_OK && !ended)
        if (whole) {
            size_t part;
            memcpy(&part, dl_message_bytes(&order), sizeof part);
            work->work(work->context, part, answers);
        }
    _exit(EXIT_SUCCESS);
}

/* In the child: it hears from the parent alone. */
static void become_lane(const lanes *all, size_t index, int orders, int answers, pid_t parent) {
    dl_process_end_with(parent);
    signal(SIGINT, SIG_IGN); /* the parent decides */
    signal(SIGTERM, SIG_DFL);
    dl_process_stay_on(index);
    for (size_t i = 0; i < index; i++)
        if (all->lane[i].orders >= 0) {
            close(all->lane[i].orders);
            close(all->lane[i].message.pipe);
        }
    serve(all->work, orders, answers);
}

/* --- the parent ---------------------------------------------------------------------------- */

static dl_status fork_lane(lanes *all, size_t index, dl_error *error) {
    int orders[2], answers[2];
    if (pipe(orders))
        return dl_fail(error, DL_IO, "a pipe for a process: %s", strerror(errno));
    if (pipe(answers)) {
        close(orders[0]);
        close(orders[1]);
        return dl_fail(error, DL_IO, "a pipe for a process: %s", strerror(errno));
    }
    const pid_t self = getpid(), child = fork();
    if (child == 0) {
        close(orders[1]);
        close(answers[0]);
        become_lane(all, index, orders[0], answers[1], self);
    }
    close(orders[0]);
    close(answers[1]);
    if (child < 0) {
        close(orders[1]);
        close(answers[0]);
        return dl_fail(error, DL_IO, "a process for cases: %s", strerror(errno));
    }
    all->lane[index] =
        (lane){.child = child, .orders = orders[1], .part = IDLE, .message = {.pipe = answers[0]}};
    return DL_OK;
}

static dl_status start(lanes *all, size_t index, dl_error *error) {
    if (!all->work->socket)
        return fork_lane(all, index, error);
    const int socket = all->work->socket[index];
    all->lane[index] = (lane){.orders = socket, .part = IDLE, .message = {.pipe = socket}};
    return DL_OK;
}

static void end_child(const lane *ending, bool by_force) {
    close(ending->orders); /* which ends an idle one */
    if (by_force)
        kill(ending->child, SIGKILL);
    while (waitpid(ending->child, NULL, 0) < 0 && errno == EINTR) {
    }
    close(ending->message.pipe);
}

/* A process elsewhere goes on waiting for orders. */
static void end_lane(lane *ending, bool by_force) {
    if (ending->child)
        end_child(ending, by_force);
    free(ending->message.data);
    *ending = (lane){.orders = -1, .part = IDLE};
}

static void lose(lanes *all, lane *lost) {
    const size_t index = (size_t)(lost - all->lane);
    if (all->work->socket) {
        close(all->work->socket[index]);
        all->work->socket[index] = -1;
    }
    if (all->work->lost)
        all->work->lost(all->work->context, index, lost->part);
    end_lane(lost, true);
}

/* The next part to a lane that has none. A lane that does not take it is lost. */
static void hand_out(lanes *all, lane *to) {
    while (all->next < all->parts && all->done[all->next])
        all->next++;
    if (to->orders < 0 || to->part != IDLE || all->next == all->parts)
        return;
    const size_t part = all->next;
    if (!dl_message_send(to->orders, &part, sizeof part)) {
        lose(all, to);
        return;
    }
    all->next++;
    to->part = (long)part;
    all->work->begun(all->work->context, part);
}

static size_t busy(const lanes *all) {
    size_t count = 0;
    for (size_t i = 0; i < all->count; i++)
        count += all->lane[i].orders >= 0 && all->lane[i].part != IDLE;
    return count;
}

static dl_status hear(lanes *all, lane *from, dl_error *error) {
    bool whole, ended;
    dl_status status = dl_message_take(&from->message, &whole, &ended, error);
    if (status == DL_IO && all->work->socket) {
        status = DL_OK; /* a connection that is broken has lost its process */
        ended = true;
    }
    ended |= whole && from->part == IDLE; /* nobody asked */
    if (status == DL_OK && whole && !ended) {
        const size_t part = (size_t)from->part;
        from->part = IDLE;
        status = all->work->receive(all->work->context, part, dl_message_bytes(&from->message),
                                    dl_message_size(&from->message), error);
        all->done[part] = status == DL_OK;
    } else if (status == DL_OK && ended) {
        lose(all, from); /* with its part */
    }
    return status;
}

static dl_status hear_all(lanes *all, dl_error *error) {
    for (size_t i = 0; i < all->count; i++)
        all->wait[i] = (struct pollfd){
            .fd = all->lane[i].orders >= 0 ? all->lane[i].message.pipe : -1, .events = POLLIN};
    const int ready = poll(all->wait, (nfds_t)all->count, 200);
    all->work->tick(all->work->context);
    if (all->work->interrupt && *all->work->interrupt)
        return dl_fail(error, DL_INTERRUPTED, "interrupted");
    dl_status status = DL_OK;
    for (size_t i = 0; i < all->count && status == DL_OK && ready > 0; i++)
        if (all->wait[i].revents)
            status = hear(all, &all->lane[i], error);
    return status;
}

static dl_status work_through(lanes *all, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < all->count; i++)
        all->lane[i] = (lane){.orders = -1, .part = IDLE};
    for (size_t i = 0; i < all->count && status == DL_OK; i++)
        status = start(all, i, error);
    while (status == DL_OK) {
        for (size_t i = 0; i < all->count; i++)
            hand_out(all, &all->lane[i]);
        if (!busy(all))
            break;
        status = hear_all(all, error);
    }
    return status;
}

dl_status dl_lanes_run(const dl_lanes_work *work, size_t count, size_t parts, bool *done,
                       dl_error *error) {
    lanes all = {.work = work, .count = count, .parts = parts, .done = done};
    all.lane = calloc(count, sizeof *all.lane);
    all.wait = calloc(count, sizeof *all.wait);
    void (*before)(int) = signal(SIGPIPE, SIG_IGN); /* a lost lane is not the end of the study */
    const dl_status status =
        all.lane && all.wait ? work_through(&all, error) : dl_fail_memory(error, "processes");
    for (size_t i = 0; all.lane && i < count; i++)
        end_lane(&all.lane[i], status != DL_OK);
    signal(SIGPIPE, before);
    free(all.lane);
    free(all.wait);
    return status;
}
