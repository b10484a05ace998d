/* Signals and the line of progress. */
#ifndef DL_CLI_TERMINAL_H
#define DL_CLI_TERMINAL_H

#include <stdbool.h>

/* From now on SIGINT and SIGTERM end the program at once, with a message and the status of what was
 * interrupted: reading a scene can take long, too. */
void cli_end_on_signals(void);

/* From now on SIGINT and SIGTERM set the flag returned instead of ending the program; the second
 * one of a kind ends it, for a step that takes too long to wait for. */
const volatile int *cli_catch_signals(void);

/* Whether somebody would see progress: standard error is a terminal. */
bool cli_shows_progress(void);

/* Replaces the line of progress; NULL clears it. */
void cli_show_progress(const char *text);

/* "1 h 05 min", "12 s" ... */
void cli_format_seconds(double seconds, char *text, int size);

/* "driftlab: MESSAGE" on standard error. */
void cli_complain(const char *message);

#endif
