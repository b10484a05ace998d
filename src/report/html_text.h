/* Plain text inside HTML, SVG and XML. */
#ifndef DL_REPORT_HTML_TEXT_H
#define DL_REPORT_HTML_TEXT_H

/* For text between tags and in quoted attributes, less the control characters that neither may
 * hold. Owned by the caller; NULL: no memory. */
char *dl_html_text(const char *plain);

#endif
