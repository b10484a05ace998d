#include "report/html_text.h"

#include <stdlib.h>
#include <string.h>

char *dl_html_text(const char *plain) {
    static const char *const entity[256] = {
        ['&'] = "&amp;", ['<'] = "&lt;", ['>'] = "&gt;", ['"'] = "&quot;"};
    char *html = malloc(strlen(plain) * strlen("&quot;") + 1);
    char *to = html;
    for (const char *c = plain; html && *c; c++) {
        const char *escaped = entity[(unsigned char)*c];
        if (escaped)
            to = stpcpy(to, escaped);
        else if ((unsigned char)*c >= 0x20 || *c == '\t' || *c == '\n')
            *to++ = *c;
    }
    if (html)
        *to = '\0';
    return html;
}
