/* The cards of all processes, through the helper that uses MPI. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "study/process.h"
#include "study/ranks.h"

enum { most_ranks = 1 << 16 };

static void become_helper(const char *helper, int in, int out, pid_t parent) {
    char size[32];
    dl_process_end_with(parent);
    snprintf(size, sizeof size, "%zu", sizeof(dl_rank_card));
    if (dup2(in, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0)
        execl(helper, helper, size, (char *)NULL);
    _exit(127);
}

static bool write_card(int to, const dl_rank_card *card) {
    return write(to, card, sizeof *card) == (ssize_t)sizeof *card; /* fits into a pipe */
}

static bool read_bytes(int from, void *data, size_t size) {
    for (char *at = data; size > 0;) {
        const ssize_t got = read(from, at, size);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        at += got;
        size -= (size_t)got;
    }
    return true;
}

static bool read_cards(int from, dl_rank_card **cards, size_t *self, size_t *count) {
    int number[2];
    if (!read_bytes(from, number, sizeof number) || number[0] < 0 || number[1] <= number[0] ||
        number[1] > most_ranks)
        return false;
    *self = (size_t)number[0];
    *count = (size_t)number[1];
    *cards = calloc(*count, sizeof **cards);
    return *cards && read_bytes(from, *cards, *count * sizeof **cards);
}

static dl_status ask(const char *helper, const int in[2], const int out[2],
                     const dl_rank_card *mine, dl_rank_card **cards, size_t *self, size_t *count,
                     dl_error *error) {
    const pid_t parent = getpid(), child = fork();
    if (child == 0)
        become_helper(helper, in[0], out[1], parent);
    close(in[0]);
    close(out[1]);
    const bool good =
        child > 0 && write_card(in[1], mine) && read_cards(out[0], cards, self, count);
    int ended = 0;
    close(in[1]);
    close(out[0]);
    while (child > 0 && waitpid(child, &ended, 0) < 0 && errno == EINTR) {
    }
    if (good && WIFEXITED(ended) && WEXITSTATUS(ended) == 0)
        return DL_OK;
    return dl_fail(error, DL_IO, "%s: the processes of mpiexec do not find each other", helper);
}

dl_status dl_ranks_exchange(const char *helper, const dl_rank_card *mine, dl_rank_card **cards,
                            size_t *self, size_t *count, dl_error *error) {
    int in[2], out[2];
    if (access(helper, X_OK))
        return dl_fail(error, DL_IO, "%s: %s", helper, strerror(errno));
    if (pipe(in))
        return dl_fail(error, DL_IO, "a pipe for a process: %s", strerror(errno));
    if (pipe(out)) {
        close(in[0]);
        close(in[1]);
        return dl_fail(error, DL_IO, "a pipe for a process: %s", strerror(errno));
    }
    return ask(helper, in, out, mine, cards, self, count, error);
}
