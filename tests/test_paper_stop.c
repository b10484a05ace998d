/* A long run of a paper at a terminal: it shows how far it is, Ctrl-C stops it, and the same
 * command goes on where it was. */
#include "fixture_runs.h"

#include <pty.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

static char folder[] = "/tmp/driftlab-stop-XXXXXX";

static void write_text(const char *name, const char *text) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static int make_folder(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    write_text(
        "ring.yaml",
        "name: ring\nsource: test\ndimension: 2\nparticles:\n"
        "  - {lattice: {kind: hexagonal, spacing: 1.2, radius: 6}, mass: 1}\n"
        "pair_law:\n"
        "  - {until: 2.3, terms: [{coefficient: -5, power: 4}, {coefficient: 5, power: 6}]}\n"
        "time: {step: 1.0e-3, end: 1, sample: 0.1}\n");
    write_text("paper.yaml",
               "name: test\ntitle: A test\nsource: nobody\n"
               "runs:\n  - {name: ring, scene: ring.yaml, end: 200, segment: 20, long: true}\n"
               "claims:\n  - {part: one, what: steps, where: x, published: \"200000\", "
               "computed: steps, run: ring}\n");
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    char command[160];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

static pid_t start(int *terminal) {
    const pid_t child = forkpty(terminal, NULL, NULL, NULL);
    assert_true(child >= 0);
    if (child == 0) {
        if (chdir(folder) == 0)
            execl(DL_PROGRAM, DL_PROGRAM, "paper", "paper.yaml", "--long", "--out", "page.html",
                  (char *)NULL);
        _exit(127);
    }
    return child;
}

/* What the program has written so far, and more of it; false at its end. */
static bool read_more(int terminal, char *text, size_t size) {
    const size_t length = strlen(text);
    if (length + 1 >= size)
        return false;
    const ssize_t got = read(terminal, text + length, size - length - 1);
    text[length + (got > 0 ? (size_t)got : 0)] = '\0';
    return got > 0;
}

static int finish(pid_t child, int terminal, char *text, size_t size) {
    int status = 0;
    while (read_more(terminal, text, size))
        ;
    assert_int_equal(waitpid(child, &status, 0), child);
    close(terminal);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static bool is_there(const char *name, struct stat *info) {
    char path[128];
    snprintf(path, sizeof path, "%s/page.html.runs/%s", folder, name);
    return stat(path, info) == 0;
}

static void ctrl_c_stops_and_the_same_command_goes_on(void **state) {
    (void)state;
    static char text[1 << 20];
    struct stat before, after;
    int terminal;
    const pid_t child = start(&terminal);
    while (!is_there("ring.part002.h5", &before) && read_more(terminal, text, sizeof text))
        ;
    assert_non_null(strstr(text, "run 1 of 1, ring: "));
    assert_int_equal(write(terminal, "\003", 1), 1); /* Ctrl-C */
    assert_int_equal(finish(child, terminal, text, sizeof text), 130);
    assert_non_null(strstr(text, " %, left "));
    assert_non_null(strstr(text, "the same command goes on from there"));
    assert_false(is_there("ring.h5", &after));
    assert_false(is_there("../page.html", &after));
    assert_true(is_there("ring.part002.h5", &before));

    memset(text, 0, sizeof text);
    const pid_t again = start(&terminal);
    assert_int_equal(finish(again, terminal, text, sizeof text), 0);
    assert_non_null(strstr(text, "1 agree, 0 differ"));
    assert_true(is_there("ring.h5", &after) && is_there("../page.html", &after));
    assert_true(is_there("ring.part002.h5", &after));
    assert_true(before.st_ino == after.st_ino && before.st_mtime == after.st_mtime);
    const char *const percent = strstr(text, "ring: ");
    assert_non_null(percent);
    assert_true(strtod(percent + 6, NULL) >= 10); /* it did not begin anew */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ctrl_c_stops_and_the_same_command_goes_on),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
