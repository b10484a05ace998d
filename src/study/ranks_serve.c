/* A process that measures cases for the first. */
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include "io/results_schema.h"
#include "study/facts.h"
#include "study/message.h"
#include "study/parts.h"
#include "study/ranks.h"

typedef struct service {
    const dl_study *study;
    dl_results *results; /* holds the references, and the facts of this process */
    int socket;
    volatile int is_over; /* the first is gone */
} service;

/* While a case runs there is nothing to read: the first is gone, or waits. */
static void look(void *context) {
    service *of = context;
    char byte;
    if (recv(of->socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0)
        of->is_over = 1;
}

/* In the place of the one of that scene. */
static dl_status take_reference(service *of, const void *bytes, size_t size, dl_error *error) {
    dl_reference sent;
    dl_results *results = of->results;
    dl_status status =
        dl_record_unpack(&dl_results_records[DL_RECORD_REFERENCES], bytes, size, &sent, error);
    if (status == DL_OK) {
        for (size_t i = 0; i < results->references; i++)
            if (strcmp(results->reference[i].scene, sent.scene) == 0) {
                dl_reference_release(&results->reference[i]);
                results->reference[i] = sent;
                return DL_OK;
            }
        status = dl_results_add_reference(results, &sent, error);
    }
    if (status != DL_OK)
        dl_reference_release(&sent);
    return status;
}

static dl_status obey(service *of, const dl_message *message, dl_error *error) {
    const char *order = dl_message_bytes(message);
    const size_t size = dl_message_size(message);
    size_t word = 0;
    if (size >= sizeof word)
        memcpy(&word, order, sizeof word);
    if (size > sizeof word && word == DL_RANK_REFERENCE)
        return take_reference(of, order + sizeof word, size - sizeof word, error);
    if (size != sizeof word || word >= of->study->cases)
        return dl_fail(error, DL_ERROR, "the first rank sent what is not expected");
    const dl_watch watch = {.interrupt = &of->is_over, .tick = look, .context = of};
    dl_part_measure_and_send(of->study, of->results, word, &watch, of->socket);
    return DL_OK;
}

static dl_status serve(service *of, dl_error *error) {
    dl_message message = {.pipe = of->socket};
    dl_status status = DL_OK;
    bool whole = false, ended = false;
    while (status == DL_OK && !ended && !of->is_over) {
        if (dl_message_take(&message, &whole, &ended, NULL) != DL_OK)
            break; /* the connection is broken: the first is gone */
        if (whole)
            status = obey(of, &message, error);
    }
    free(message.data);
    return status;
}

static bool say(int socket, dl_rank_word word, const char *text) {
    char *message = dl_text("%c%s", (char)word, text);
    const bool said = message && dl_message_send(socket, message, strlen(message) + 1);
    free(message);
    return said;
}

static dl_status say_identity(const service *of, dl_error *error) {
    dl_status status = dl_facts_add(of->results, NULL, error);
    if (status != DL_OK)
        return status;
    char *identity = dl_ranks_identity(of->study, of->results);
    if (identity)
        say(of->socket, DL_RANK_SERVES, identity); /* in vain where the first is gone */
    free(identity);
    return identity ? DL_OK : dl_fail_memory(error, "the processes of mpiexec");
}

dl_status dl_ranks_serve(dl_ranks *ranks, const dl_study *study, const char *why, dl_error *error) {
    service of = {.study = study, .socket = ranks->socket[0]};
    if (!study) {
        say(of.socket, DL_RANK_FAILED, why);
        return DL_OK;
    }
    dl_status status = dl_results_create(&of.results, error);
    if (status == DL_OK)
        status = say_identity(&of, error);
    if (status == DL_OK)
        status = serve(&of, error);
    dl_results_free(of.results);
    return status;
}
