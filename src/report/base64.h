/* Bytes as text (RFC 4648). */
#ifndef DL_REPORT_BASE64_H
#define DL_REPORT_BASE64_H

#include <stddef.h>

/* Owned by the caller; NULL: no memory. */
char *dl_base64(const unsigned char *bytes, size_t count);

#endif
