/* What a process does to itself: processors it keeps to, and its end with its parent. */
#ifndef DL_STUDY_PROCESS_H
#define DL_STUDY_PROCESS_H

#include <stddef.h>
#include <sys/types.h>

/* Ends this process, by SIGKILL, when `parent` ends; at once where it has. */
void dl_process_end_with(pid_t parent);

/* Processors that this process may use. */
size_t dl_process_processors(void);

/* Keeps to the one it runs on, or to the `index`-th of those it may use. Where the system does not
 * say or let it, nothing happens: times are noisier then. */
void dl_process_stay_here(void);
void dl_process_stay_on(size_t index);

#endif
