/* Run-time choice of the instruction set. */
#include "force/vector_ops.h"

#include <string.h>

extern const dl_vector_ops dl_vector_ops_plain;
#ifdef DL_HAVE_X86_VARIANTS
extern const dl_vector_ops dl_vector_ops_avx2, dl_vector_ops_avx512;
#endif

static const dl_vector_ops *forced;

static const dl_vector_ops *widest(void) {
#ifdef DL_HAVE_X86_VARIANTS
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        return &dl_vector_ops_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return &dl_vector_ops_avx2;
#endif
    return &dl_vector_ops_plain;
}

const dl_vector_ops *dl_vector_best(void) {
    return forced ? forced : widest();
}

bool dl_vector_force(const char *name) {
    const dl_vector_ops *can[3] = {&dl_vector_ops_plain};
    size_t count = 1;
#ifdef DL_HAVE_X86_VARIANTS
    const dl_vector_ops *best = widest();
    if (best != &dl_vector_ops_plain)
        can[count++] = &dl_vector_ops_avx2;
    if (best == &dl_vector_ops_avx512)
        can[count++] = &dl_vector_ops_avx512;
#endif
    forced = NULL;
    for (size_t k = 0; name && k < count; k++)
        if (strcmp(can[k]->name, name) == 0)
            forced = can[k];
    return !name || forced;
}

/* Seven arrays of a row each, with room before and behind it (see pairs_vector.c), or of a batch
 * where that is longer. */
size_t dl_row_buffer_size(size_t particles) {
    size_t row = particles > 640 ? particles : 640;
    return 7 * (row + 2 * (size_t)DL_VECTOR_PAD);
}
