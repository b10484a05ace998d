#ifdef __linux__
#define _GNU_SOURCE /* sched_getaffinity */
#include <sched.h>
#endif
#include "study/ranks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "study/process.h"

/* What Open MPI's mpiexec tells those it starts; 0: nothing. */
static size_t told(const char *name) {
    const char *text = getenv(name);
    const long value = text ? strtol(text, NULL, 10) : 0;
    return value > 0 ? (size_t)value : 0;
}

size_t dl_ranks_started(void) {
    const size_t count = told("OMPI_COMM_WORLD_SIZE");
    return count > 0 ? count : 1;
}

bool dl_ranks_is_first(const dl_ranks *ranks) {
    return ranks->self == 0;
}

static void describe_self(dl_rank_card *card) {
    if (gethostname(card->host, sizeof card->host - 1))
        snprintf(card->host, sizeof card->host, "unknown");
#ifdef __linux__
    cpu_set_t set;
    _Static_assert(sizeof set <= dl_processor_bytes, "room for the processors");
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        memcpy(card->processors, &set, sizeof set);
#endif
}

/* Of those that serve on one machine and may use the same processors, each keeps to one of its own
 * while there are enough. */
static void take_processor(const dl_rank_card *card, size_t self) {
    size_t place = 0;
    for (size_t i = 1; i < self; i++)
        place += strcmp(card[i].host, card[self].host) == 0 &&
                 memcmp(card[i].processors, card[self].processors, dl_processor_bytes) == 0;
    dl_process_stay_on(place % dl_process_processors());
}

static dl_ranks *create(const dl_rank_card *card, size_t self, size_t count) {
    dl_ranks *ranks = calloc(1, sizeof *ranks);
    if (!ranks)
        return NULL;
    *ranks = (dl_ranks){.self = self,
                        .count = count,
                        .rank = calloc(count, sizeof *ranks->rank),
                        .socket = calloc(count, sizeof *ranks->socket)};
    if (!ranks->rank || !ranks->socket) {
        free(ranks->rank);
        free(ranks->socket);
        free(ranks);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(ranks->rank[i].host, card[i].host, sizeof card[i].host - 1);
        ranks->socket[i] = -1;
    }
    return ranks;
}

/* mpiexec ends all its processes with one that is killed. The child is not one of them: it ends
 * with its connection to the first. */
static dl_status let_go(dl_error *error) {
    const pid_t child = fork();
    if (child > 0)
        _exit(EXIT_SUCCESS);
    return child == 0 ? DL_OK : dl_fail(error, DL_IO, "mpiexec: a process that serves: no fork");
}

static dl_status connect_all(dl_ranks *ranks, int listener, const dl_rank_card *card,
                             dl_error *error) {
    if (ranks->self == 0)
        return dl_ranks_accept(ranks, listener, &card[0], error);
    const dl_status status = dl_ranks_connect(ranks, &card[0], error);
    if (status != DL_OK)
        return status;
    take_processor(card, ranks->self);
    return let_go(error);
}

dl_status dl_ranks_join(const char *helper, dl_ranks **ranks, dl_error *error) {
    dl_rank_card mine = {.host = ""}, *card = NULL;
    int listener = -1;
    size_t self, count;
    dl_status status = DL_OK;
    *ranks = NULL;
    dl_process_end_with(getppid()); /* a study is not to outlive its mpiexec */
    describe_self(&mine);
    if (told("OMPI_COMM_WORLD_RANK") == 0)
        status = dl_ranks_listen(told("OMPI_COMM_WORLD_LOCAL_SIZE") == dl_ranks_started(), &mine,
                                 &listener, error);
    if (status == DL_OK)
        status = dl_ranks_exchange(helper, &mine, &card, &self, &count, error);
    if (status == DL_OK && !(*ranks = create(card, self, count)))
        status = dl_fail_memory(error, "the processes of mpiexec");
    if (status == DL_OK)
        status = connect_all(*ranks, listener, card, error);
    if (listener >= 0)
        close(listener);
    free(card);
    if (status != DL_OK) {
        dl_ranks_leave(*ranks);
        *ranks = NULL;
    }
    return status;
}

void dl_ranks_leave(dl_ranks *ranks) {
    if (!ranks)
        return;
    for (size_t i = 0; i < ranks->count; i++)
        if (ranks->socket[i] >= 0)
            close(ranks->socket[i]);
    free(ranks->rank);
    free(ranks->socket);
    free(ranks);
}
