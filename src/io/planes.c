#include "io/planes.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { planes = sizeof(double), level = 1 };

static void shuffle(const double *values, size_t count, unsigned char *plane) {
    for (size_t i = 0; i < count; i++) {
        unsigned char byte[planes];
        memcpy(byte, &values[i], sizeof byte);
        for (size_t k = 0; k < planes; k++)
            plane[k * count + i] = byte[k];
    }
}

/* Whether two bytes of it are equal hardly more often than by chance, 1 in 256. */
static bool is_noise(const unsigned char *plane, size_t count) {
    size_t seen[256] = {0};
    double pairs = 0;
    for (size_t i = 0; i < count; i++)
        seen[plane[i]]++;
    for (size_t k = 0; k < 256; k++)
        pairs += (double)seen[k] * ((double)seen[k] - 1);
    return count > 1 && pairs * 256 < 1.5 * (double)count * ((double)count - 1);
}

static bool add_plane(z_stream *stream, unsigned char *plane, size_t count, bool is_last) {
    if (deflateParams(stream, is_noise(plane, count) ? 0 : level, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    stream->next_in = plane;
    stream->avail_in = (uInt)count;
    const int got = deflate(stream, is_last ? Z_FINISH : Z_NO_FLUSH);
    return is_last ? got == Z_STREAM_END : got == Z_OK && stream->avail_in == 0;
}

static size_t deflate_planes(unsigned char *plane, size_t count, unsigned char *out, size_t room) {
    z_stream stream = {.next_out = out, .avail_out = (uInt)room};
    if (deflateInit(&stream, level) != Z_OK)
        return 0;
    bool good = true;
    for (size_t k = 0; k < planes && good; k++)
        good = add_plane(&stream, plane + k * count, count, k + 1 == planes);
    const size_t size = good ? (size_t)stream.total_out : 0;
    deflateEnd(&stream);
    return size;
}

size_t dl_planes_deflate(const double *values, size_t count, unsigned char **bytes) {
    const size_t size = planes * count;
    /* Blocks that are stored or begun anew cost some bytes more. */
    const size_t room = (size_t)compressBound((uLong)size) + size / 64 + 4096;
    unsigned char *plane = malloc(size ? size : 1);
    *bytes = malloc(room);
    size_t got = 0;
    if (plane && *bytes && room < (uInt)-1) {
        shuffle(values, count, plane);
        got = deflate_planes(plane, count, *bytes, room);
    }
    free(plane);
    if (got == 0) {
        free(*bytes);
        *bytes = NULL;
    }
    return got;
}
