/* The sockets between the first process and those that serve it. */
#ifdef __linux__
#define _GNU_SOURCE /* SOCK_CLOEXEC, TCP_KEEPIDLE */
#endif
#include <errno.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#include "study/ranks.h"

enum { patience = 60, answer_patience = 5 }; /* seconds */

/* What a serving process says before all else. */
typedef struct introduction {
    unsigned char token[dl_token_half];
    uint64_t rank;
} introduction;

static void set_limit(int socket, int option, int seconds) {
    const struct timeval limit = {.tv_sec = seconds};
    setsockopt(socket, SOL_SOCKET, option, &limit, sizeof limit);
}

/* Orders are small and waited for. A machine that is lost without a word is noticed after a
 * minute. */
static void set_up(int socket) {
    static const struct {
        int level, name, value;
    } options[] = {
        {SOL_SOCKET, SO_KEEPALIVE, 1},   {IPPROTO_TCP, TCP_NODELAY, 1},
#ifdef __linux__
        {IPPROTO_TCP, TCP_KEEPIDLE, 30}, {IPPROTO_TCP, TCP_KEEPINTVL, 10},
        {IPPROTO_TCP, TCP_KEEPCNT, 3},   {IPPROTO_TCP, TCP_USER_TIMEOUT, 60000},
#endif
    };
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        setsockopt(socket, options[i].level, options[i].name, &options[i].value,
                   sizeof options[i].value);
    set_limit(socket, SO_RCVTIMEO, 0);
    set_limit(socket, SO_SNDTIMEO, patience);
}

static void list_addresses(dl_rank_card *card) {
    struct ifaddrs *all = NULL;
    if (getifaddrs(&all))
        return;
    for (const struct ifaddrs *at = all; at && card->addresses < dl_most_addresses;
         at = at->ifa_next) {
        if (!at->ifa_addr || at->ifa_addr->sa_family != AF_INET || !(at->ifa_flags & IFF_UP) ||
            (at->ifa_flags & IFF_LOOPBACK))
            continue;
        struct sockaddr_in found;
        memcpy(&found, at->ifa_addr, sizeof found);
        card->address[card->addresses++] = found.sin_addr;
    }
    freeifaddrs(all);
}

dl_status dl_ranks_listen(bool here, dl_rank_card *card, int *listener, dl_error *error) {
    struct sockaddr_in at = {.sin_family = AF_INET,
                             .sin_addr.s_addr = htonl(here ? INADDR_LOOPBACK : INADDR_ANY)};
    socklen_t size = sizeof at;
    *listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (*listener < 0 || bind(*listener, (const struct sockaddr *)&at, sizeof at) ||
        listen(*listener, SOMAXCONN) || getsockname(*listener, (struct sockaddr *)&at, &size) ||
        getrandom(card->token, sizeof card->token, 0) != (ssize_t)sizeof card->token) {
        const int why = errno;
        if (*listener >= 0)
            close(*listener);
        return dl_fail(error, DL_IO, "a socket for the processes of mpiexec: %s", strerror(why));
    }
    card->port = at.sin_port;
    card->addresses = 0;
    if (here)
        card->address[card->addresses++].s_addr = htonl(INADDR_LOOPBACK);
    else
        list_addresses(card);
    return DL_OK;
}

/* --- the first ------------------------------------------------------------------------------ */

/* Takes a connection for one of this study's; closes any other. */
static bool admit(dl_ranks *ranks, int socket, const dl_rank_card *card) {
    introduction said;
    set_limit(socket, SO_RCVTIMEO, answer_patience);
    const bool good =
        recv(socket, &said, sizeof said, MSG_WAITALL) == (ssize_t)sizeof said &&
        memcmp(said.token, card->token, sizeof said.token) == 0 && said.rank > 0 &&
        said.rank < ranks->count && ranks->socket[said.rank] < 0 &&
        send(socket, card->token + dl_token_half, dl_token_half, MSG_NOSIGNAL) == dl_token_half;
    if (good) {
        set_up(socket);
        ranks->socket[said.rank] = socket;
    } else {
        close(socket);
    }
    return good;
}

dl_status dl_ranks_accept(dl_ranks *ranks, int listener, const dl_rank_card *card,
                          dl_error *error) {
    size_t missing = ranks->count - 1;
    const time_t end = time(NULL) + patience;
    while (missing > 0 && time(NULL) < end) {
        struct pollfd wait = {.fd = listener, .events = POLLIN};
        if (poll(&wait, 1, 1000) <= 0)
            continue;
        const int socket = accept(listener, NULL, NULL);
        if (socket < 0)
            continue;
        fcntl(socket, F_SETFD, FD_CLOEXEC);
        missing -= admit(ranks, socket, card);
    }
    for (size_t i = 1; i < ranks->count && missing > 0; i++)
        if (ranks->socket[i] < 0)
            return dl_fail(error, DL_IO,
                           "mpiexec: %zu of %zu processes (rank %zu on %s ...) have not reached "
                           "the first within %d s",
                           missing, ranks->count, i, ranks->rank[i].host, (int)patience);
    return DL_OK;
}

/* --- the others ----------------------------------------------------------------------------- */

static bool reach(int socket, struct in_addr address, in_port_t port) {
    const struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = port, .sin_addr = address};
    int failed = 0;
    socklen_t size = sizeof failed;
    const int flags = fcntl(socket, F_GETFL);
    if (fcntl(socket, F_SETFL, flags | O_NONBLOCK))
        return false;
    if (connect(socket, (const struct sockaddr *)&to, sizeof to) && errno != EINPROGRESS)
        return false;
    struct pollfd wait = {.fd = socket, .events = POLLOUT};
    return poll(&wait, 1, 1000 * answer_patience) == 1 &&
           getsockopt(socket, SOL_SOCKET, SO_ERROR, &failed, &size) == 0 && failed == 0 &&
           fcntl(socket, F_SETFL, flags) == 0;
}

/* The first may take a while to admit all; a stranger never answers. */
static bool introduce(int socket, size_t self, const dl_rank_card *first) {
    introduction said = {.rank = self};
    unsigned char answer[dl_token_half];
    memcpy(said.token, first->token, sizeof said.token);
    set_limit(socket, SO_RCVTIMEO, patience);
    return send(socket, &said, sizeof said, MSG_NOSIGNAL) == (ssize_t)sizeof said &&
           recv(socket, answer, sizeof answer, MSG_WAITALL) == (ssize_t)sizeof answer &&
           memcmp(answer, first->token + dl_token_half, sizeof answer) == 0;
}

dl_status dl_ranks_connect(dl_ranks *ranks, const dl_rank_card *first, dl_error *error) {
    for (uint32_t i = 0; i < first->addresses && i < dl_most_addresses; i++) {
        const int to = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        if (to < 0)
            break;
        if (reach(to, first->address[i], first->port) && introduce(to, ranks->self, first)) {
            set_up(to);
            ranks->socket[0] = to;
            return DL_OK;
        }
        close(to);
    }
    return dl_fail(error, DL_IO,
                   "mpiexec: rank %zu on %s does not reach the first, on %s, by any of its %u "
                   "addresses (IPv4)",
                   ranks->self, ranks->rank[ranks->self].host, first->host,
                   (unsigned)first->addresses);
}
