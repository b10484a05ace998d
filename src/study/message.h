/* Messages through a pipe: a size, then as many bytes. */
#ifndef DL_STUDY_MESSAGE_H
#define DL_STUDY_MESSAGE_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

/* The message that is arriving. Zeroed but for the pipe to begin with; `data` is freed by its
 * owner. */
typedef struct dl_message {
    int pipe;
    char *data; /* size, then bytes */
    size_t length, room;
} dl_message;

/* Writes one message; false where nobody reads any more. */
bool dl_message_send(int pipe, const void *data, size_t size);

/* Reads what there is. *whole: a message is complete; its bytes, aligned for doubles, hold until
 * the next call. *ended: the writer has closed its end. */
dl_status dl_message_take(dl_message *message, bool *whole, bool *ended, dl_error *error);

const void *dl_message_bytes(const dl_message *message);
size_t dl_message_size(const dl_message *message);

#endif
