#include "study/message.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool write_all(int pipe, const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        ssize_t written = write(pipe, at, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return false;
        at += written;
        size -= (size_t)written;
    }
    return true;
}

bool dl_message_send(int pipe, const void *data, size_t size) {
    return write_all(pipe, &size, sizeof size) && write_all(pipe, data, size);
}

const void *dl_message_bytes(const dl_message *message) {
    return message->data + sizeof(size_t);
}

size_t dl_message_size(const dl_message *message) {
    size_t size = 0;
    memcpy(&size, message->data, sizeof size);
    return size;
}

/* Bytes that are wanted next. */
static size_t wanted(const dl_message *message) {
    if (message->length < sizeof(size_t))
        return sizeof(size_t) - message->length;
    return sizeof(size_t) + dl_message_size(message) - message->length;
}

static dl_status make_room(dl_message *message, size_t more, dl_error *error) {
    if (message->length + more <= message->room)
        return DL_OK;
    char *grown = realloc(message->data, message->length + more);
    if (!grown)
        return dl_fail_memory(error, "a message of another process");
    message->data = grown;
    message->room = message->length + more;
    return DL_OK;
}

dl_status dl_message_take(dl_message *message, bool *whole, bool *ended, dl_error *error) {
    *whole = *ended = false;
    if (message->length >= sizeof(size_t) && wanted(message) == 0)
        message->length = 0; /* the last one has been read */
    const size_t more = wanted(message);
    dl_status status = make_room(message, more, error);
    if (status != DL_OK)
        return status;
    ssize_t got = read(message->pipe, message->data + message->length, more);
    if (got < 0 && errno != EINTR)
        return dl_fail(error, DL_IO, "reading from another process: %s", strerror(errno));
    if (got <= 0) {
        *ended = got == 0;
        return DL_OK;
    }
    message->length += (size_t)got;
    *whole = message->length >= sizeof(size_t) && wanted(message) == 0;
    return DL_OK;
}
