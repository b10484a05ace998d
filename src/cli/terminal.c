#include "cli/terminal.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "cli/command.h"

static volatile int interrupted;
static bool is_watched; /* someone sees what is said */

/* A step can be long. */
static void on_signal(int number) {
    static const char message[] = "\ndriftlab: ends with the step at work; again ends it at once\n";
    (void)number;
    interrupted = 1;
    if (is_watched && write(STDERR_FILENO, message, sizeof message - 1) < 0)
        return;
}

static void catch_with(void (*handler)(int), int flags) {
    struct sigaction action = {.sa_handler = handler, .sa_flags = flags};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

const volatile int *cli_catch_signals(void) {
    is_watched = isatty(STDERR_FILENO) == 1;
    catch_with(on_signal, (int)SA_RESETHAND);
    return &interrupted;
}

static void end_interrupted(int number) {
    static const char message[] = "driftlab: interrupted\n";
    (void)number;
    if (write(STDERR_FILENO, message, sizeof message - 1) < 0)
        _exit(CLI_INTERRUPTED);
    _exit(CLI_INTERRUPTED);
}

void cli_end_on_signals(void) {
    catch_with(end_interrupted, 0);
}

bool cli_shows_progress(void) {
    return isatty(STDERR_FILENO) == 1;
}

void cli_show_progress(const char *text) {
    /* ECMA-48: erase to the end of the line. */
    fprintf(stderr, "\r%s\033[K", text ? text : "");
    fflush(stderr);
}

void cli_format_seconds(double seconds, char *text, int size) {
    const long whole = (long)(seconds + 0.5);
    if (!(seconds < 1e8))
        snprintf(text, (size_t)size, "?");
    else if (whole < 100)
        snprintf(text, (size_t)size, "%ld s", whole);
    else if (whole < 6000)
        snprintf(text, (size_t)size, "%ld min %02ld s", whole / 60, whole % 60);
    else
        snprintf(text, (size_t)size, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
}

void cli_complain(const char *message) {
    fprintf(stderr, "driftlab: %s\n", message);
}
