/* One measurement in a process of its own: its memory lies as in a fresh run, not where earlier
 * measurements have left room, which alone can make a step a tenth slower. */
#ifndef DL_BENCH_ALONE_H
#define DL_BENCH_ALONE_H

#include <stddef.h>
#include "driftlab/status.h"

/* result [size], at most DL_BENCH_MOST_RESULT bytes; what it points to must have been there before.
 */
enum { DL_BENCH_MOST_RESULT = 256 };
typedef dl_status dl_bench_work(const void *what, void *result, dl_error *error);
dl_status dl_bench_alone(dl_bench_work *work, const void *what, void *result, size_t size,
                         dl_error *error);

#endif
