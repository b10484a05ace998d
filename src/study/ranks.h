/* The processes of mpiexec: how they are introduced, connected, and what they say first. */
#ifndef DL_STUDY_RANKS_H
#define DL_STUDY_RANKS_H

#include <netinet/in.h>
#include <stdint.h>
#include "driftlab/ranks.h"
#include "study/plan.h"

enum { dl_most_addresses = 8, dl_token_half = 16, dl_processor_bytes = 128 };

/* What each tells all: plain bytes, the same layout in each. */
typedef struct dl_rank_card {
    char host[64];
    unsigned char processors[dl_processor_bytes]; /* those it may use, a bit each */
    /* Of the first: where it listens (IPv4), and what two processes of this study prove to each
     * other, a half each. */
    uint32_t addresses;
    struct in_addr address[dl_most_addresses];
    in_port_t port; /* in network order */
    unsigned char token[2 * dl_token_half];
} dl_rank_card;

typedef struct dl_rank {
    char host[64];
} dl_rank;

struct dl_ranks {
    size_t self, count;
    dl_rank *rank; /* [count] */
    int *socket;   /* [count]: of the first to each that serves, of one that serves to the first
                      (socket[0]); -1: none, or lost */
};

/* Gives every process's card to every process: *cards [*count] is the caller's. */
dl_status dl_ranks_exchange(const char *helper, const dl_rank_card *mine, dl_rank_card **cards,
                            size_t *self, size_t *count, dl_error *error);

/* Listens, and puts into the card where. `here`: all are on this machine. */
dl_status dl_ranks_listen(bool here, dl_rank_card *card, int *listener, dl_error *error);
/* Of the first: waits until all others are connected, at most a minute. */
dl_status dl_ranks_accept(dl_ranks *ranks, int listener, const dl_rank_card *card, dl_error *error);
/* Of the others. */
dl_status dl_ranks_connect(dl_ranks *ranks, const dl_rank_card *first, dl_error *error);

typedef struct dl_ranks_check {
    const dl_study *study;
    const dl_results *results; /* with the facts of this process */
    void (*lost)(void *context, size_t rank, long part);
    void *context;
    const volatile int *interrupt;
} dl_ranks_check;

/* Of the first: hears from each other what it is about to measure, with what and on what. DL_INPUT
 * where one could not read the study, or its times could not be compared with the others'. */
dl_status dl_ranks_agree(dl_ranks *ranks, const dl_ranks_check *check, dl_error *error);

/* Of the first: gives all references of the results to the others. One that does not take them is
 * found lost with its first part. */
dl_status dl_ranks_send_references(dl_ranks *ranks, const dl_results *results, dl_error *error);

/* Order of the first to another: a part's number, or this and a packed reference. */
#define DL_RANK_REFERENCE SIZE_MAX

/* What must be the same in every process: the study's cases, the build, the processor. Lines "NAME:
 * VALUE", owned by the caller; NULL: no memory. */
char *dl_ranks_identity(const dl_study *study, const dl_results *results);

/* First byte of what a process that serves says first: its identity follows, or why it cannot
 * serve. */
typedef enum dl_rank_word { DL_RANK_SERVES = 's', DL_RANK_FAILED = 'f' } dl_rank_word;

#endif
