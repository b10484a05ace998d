/* What the first process says to the others and hears of them, but for the cases (lanes.h). */
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "io/results_schema.h"
#include "study/facts.h"
#include "study/kind.h"
#include "study/message.h"
#include "study/ranks.h"

char *dl_ranks_identity(const dl_study *study, const dl_results *results) {
    char *text = dl_text("study: %016llx\n", (unsigned long long)dl_study_hash(study));
    for (const char *const *fact = dl_facts_of_timing; text && *fact; fact++) {
        const char *value = dl_results_fact(results, *fact);
        char *longer = dl_text("%s%s: %s\n", text, *fact, value ? value : "");
        free(text);
        text = longer;
    }
    return text;
}

/* Where the line begins that differs; NULL: none does. */
static const char *first_difference(const char *a, const char *b) {
    const char *line = a;
    for (; *a && *a == *b; a++, b++)
        if (*a == '\n')
            line = a + 1;
    return *a || *b ? line : NULL;
}

static dl_status compare(const dl_ranks *ranks, size_t rank, const char *said, const char *own,
                         dl_error *error) {
    const char *other = first_difference(said, own), *mine = first_difference(own, said);
    if (!other || !mine)
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "rank %zu on %s: found another study, build or machine (\"%.*s\"), expected the "
                   "first rank's (\"%.*s\"): times would not compare",
                   rank, ranks->rank[rank].host, (int)strcspn(other, "\n"), other,
                   (int)strcspn(mine, "\n"), mine);
}

static dl_status judge(const dl_ranks *ranks, size_t rank, const dl_message *message,
                       const char *own, dl_error *error) {
    const char *said = dl_message_bytes(message);
    const size_t size = dl_message_size(message);
    if (size < 2 || said[size - 1] != '\0')
        return dl_fail(error, DL_ERROR, "rank %zu on %s: what it sent is damaged", rank,
                       ranks->rank[rank].host);
    if (said[0] == DL_RANK_SERVES)
        return compare(ranks, rank, said + 1, own, error);
    return dl_fail(error, DL_INPUT, "rank %zu on %s: %s", rank, ranks->rank[rank].host, said + 1);
}

/* Waits for one message; *lost where the connection ends instead. */
static dl_status listen_to(dl_message *message, const volatile int *interrupt, bool *lost,
                           dl_error *error) {
    bool whole = false;
    *lost = false;
    while (!whole && !*lost) {
        struct pollfd wait = {.fd = message->pipe, .events = POLLIN};
        const int ready = poll(&wait, 1, 200);
        if (interrupt && *interrupt)
            return dl_fail(error, DL_INTERRUPTED, "interrupted");
        if (ready > 0 && dl_message_take(message, &whole, lost, NULL) != DL_OK)
            *lost = true;
    }
    return DL_OK;
}

static dl_status hear(dl_ranks *ranks, size_t rank, const dl_ranks_check *check, const char *own,
                      dl_error *error) {
    dl_message message = {.pipe = ranks->socket[rank]};
    bool lost;
    dl_status status = listen_to(&message, check->interrupt, &lost, error);
    if (status == DL_OK && lost) {
        close(ranks->socket[rank]);
        ranks->socket[rank] = -1;
        check->lost(check->context, rank, -1);
    } else if (status == DL_OK) {
        status = judge(ranks, rank, &message, own, error);
    }
    free(message.data);
    return status;
}

dl_status dl_ranks_agree(dl_ranks *ranks, const dl_ranks_check *check, dl_error *error) {
    char *own = dl_ranks_identity(check->study, check->results);
    dl_status status = own ? DL_OK : dl_fail_memory(error, "the processes of mpiexec");
    for (size_t i = 1; i < ranks->count && status == DL_OK; i++)
        if (ranks->socket[i] >= 0)
            status = hear(ranks, i, check, own, error);
    free(own);
    return status;
}

static dl_status send_reference(const dl_ranks *ranks, const dl_reference *reference,
                                dl_error *error) {
    const size_t word = DL_RANK_REFERENCE;
    void *bytes = NULL;
    size_t size = 0;
    const dl_status status =
        dl_record_pack(&dl_results_records[DL_RECORD_REFERENCES], reference, &bytes, &size, error);
    if (status != DL_OK)
        return status;
    char *order = malloc(sizeof word + size);
    if (order) {
        memcpy(order, &word, sizeof word);
        memcpy(order + sizeof word, bytes, size);
    }
    for (size_t i = 1; i < ranks->count && order; i++)
        if (ranks->socket[i] >= 0)
            dl_message_send(ranks->socket[i], order, sizeof word + size);
    free(bytes);
    free(order);
    return order ? DL_OK : dl_fail_memory(error, "a reference");
}

dl_status dl_ranks_send_references(dl_ranks *ranks, const dl_results *results, dl_error *error) {
    void (*before)(int) = signal(SIGPIPE, SIG_IGN);
    dl_status status = DL_OK;
    for (size_t i = 0; i < results->references && status == DL_OK; i++)
        status = send_reference(ranks, &results->reference[i], error);
    signal(SIGPIPE, before);
    return status;
}
