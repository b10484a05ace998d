#include "study/verdicts.h"

#include <string.h>
#include "study/finding.h"

bool dl_verdict_is(const dl_finding *finding, const char *scene, const char *verdict) {
    return strcmp(finding->scene, scene) == 0 &&
           (!verdict || strcmp(finding->verdict, verdict) == 0);
}

size_t dl_verdict_count(const dl_results *results, const char *scene, const char *verdict) {
    size_t found = 0;
    for (size_t i = 0; i < results->findings; i++)
        found += dl_verdict_is(&results->finding[i], scene, verdict);
    return found;
}

void dl_verdict_list(const dl_results *results, const char *scene, const char *verdict,
                     bool fineness, FILE *out) {
    enum { most = 3 };
    size_t named = 0;
    const char *last = "";
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *finding = &results->finding[i];
        char finer[64] = "";
        if (!dl_verdict_is(finding, scene, verdict) ||
            (!fineness && strcmp(finding->method, last) == 0))
            continue;
        last = finding->method;
        if (named++ >= most)
            continue;
        if (fineness)
            dl_finding_fineness(finding, finer, sizeof finer);
        fprintf(out, "%s%s%s%s", named > 1 ? ", " : " (", finding->method, *finer ? " " : "",
                finer);
    }
    if (named > most)
        fprintf(out, " and %zu more", named - most);
    if (named > 0)
        fputc(')', out);
}
