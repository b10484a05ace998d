#include "report/base64.h"

#include <stdlib.h>

char *dl_base64(const unsigned char *bytes, size_t count) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *const text = malloc((count + 2) / 3 * 4 + 1);
    char *to = text;
    for (size_t i = 0; text && i < count; i += 3) {
        const size_t left = count - i;
        const unsigned group = (unsigned)bytes[i] << 16 |
                               (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                               (left > 2 ? (unsigned)bytes[i + 2] : 0);
        *to++ = digit[group >> 18];
        *to++ = digit[group >> 12 & 63];
        *to++ = left > 1 ? digit[group >> 6 & 63] : '=';
        *to++ = left > 2 ? digit[group & 63] : '=';
    }
    if (text)
        *to = '\0';
    return text;
}
