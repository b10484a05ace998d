/* Versions: of driftlab, of the libraries it runs with, and what built it. */
#ifndef DRIFTLAB_VERSION_H
#define DRIFTLAB_VERSION_H

#include <stddef.h>

/* "0.1.0" */
const char *dl_version(void);

typedef struct dl_component {
    const char *name, *version;
} dl_component;

#define DL_MAX_COMPONENTS 8

/* The libraries as loaded at run time, the compiler and the build type: name and version of each
 * into components [DL_MAX_COMPONENTS]; returns how many. The texts are static. */
size_t dl_components(dl_component *components);

#endif
