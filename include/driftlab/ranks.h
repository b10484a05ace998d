/* A study on the processes that mpiexec has started, on one machine or several.
 *
 * The first of them hands out the cases and writes the results; the others serve it. They find each
 * other through MPI and then talk through sockets: a process that is lost is noticed at once, and
 * one that waits takes no processor time. Serving processes let go of mpiexec, which would end all
 * of them with any one that is killed; they end with the first. */
#ifndef DRIFTLAB_RANKS_H
#define DRIFTLAB_RANKS_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"
#include "driftlab/study.h"

typedef struct dl_ranks dl_ranks;

/* How many processes Open MPI's mpiexec has started as one with this; 1: it has not. */
size_t dl_ranks_started(void);

/* Joins them; all must call it, before anything that takes long. `helper`: the program
 * driftlab-ranks. DL_IO where they do not find each other. In a serving process this returns in a
 * child: the process that mpiexec knows ends well. */
dl_status dl_ranks_join(const char *helper, dl_ranks **ranks, dl_error *error);
void dl_ranks_leave(dl_ranks *ranks);

/* Whether this is the one that runs the study (dl_study_options.ranks); else it is to serve. */
bool dl_ranks_is_first(const dl_ranks *ranks);

/* Measures cases until the first process has no more. The study is the same in all of them; NULL
 * where it could not be read, and then `why` says so to the first. DL_OK also where the first is
 * gone. */
dl_status dl_ranks_serve(dl_ranks *ranks, const dl_study *study, const char *why, dl_error *error);

#endif
