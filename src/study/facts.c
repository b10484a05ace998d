#include "study/facts.h"

#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>
#include "driftlab/version.h"
#include "source_hash.h"
#include "version.h"

const char *const dl_facts_of_timing[] = {"source", "SUNDIALS", "GSL",       "compiler",
                                          "build",  "flags",    "processor", NULL};

static void find_processor(char *name, size_t size) {
    snprintf(name, size, "unknown");
    FILE *list = fopen("/proc/cpuinfo", "r");
    char line[512];
    while (list && fgets(line, sizeof line, list)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon) {
            snprintf(name, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    }
    if (list)
        fclose(list);
}

static void find_distribution(char *name, size_t size) {
    name[0] = '\0';
    FILE *list = fopen("/etc/os-release", "r");
    char line[512];
    while (list && fgets(line, sizeof line, list)) {
        if (strncmp(line, "PRETTY_NAME=", 12) == 0) {
            const char *value = line + 12 + (line[12] == '"');
            snprintf(name, size, "%.*s", (int)strcspn(value, "\"\n"), value);
        }
    }
    if (list)
        fclose(list);
}

static void describe_system(char *text, size_t size) {
    struct utsname system;
    char distribution[256];
    find_distribution(distribution, sizeof distribution);
    if (uname(&system) == 0)
        snprintf(text, size, "%s%s%s %s %s", distribution, *distribution ? ", " : "",
                 system.sysname, system.release, system.machine);
    else
        snprintf(text, size, "%s", distribution);
}

static dl_status add_machine(dl_results *results, dl_error *error) {
    char processor[256], processors[32], system[768];
    find_processor(processor, sizeof processor);
    snprintf(processors, sizeof processors, "%ld", sysconf(_SC_NPROCESSORS_ONLN));
    describe_system(system, sizeof system);
    dl_status status = dl_results_add_fact(results, "processor", processor, error);
    if (status == DL_OK)
        status = dl_results_add_fact(results, "processors", processors, error);
    return status == DL_OK ? dl_results_add_fact(results, "system", system, error) : status;
}

static dl_status add_build(dl_results *results, dl_error *error) {
    dl_component component[DL_MAX_COMPONENTS];
    const size_t count = dl_components(component);
    dl_status status = dl_results_add_fact(results, "driftlab", dl_version(), error);
    for (size_t i = 0; i < count && status == DL_OK; i++)
        status = dl_results_add_fact(results, component[i].name, component[i].version, error);
    if (status == DL_OK)
        status = dl_results_add_fact(results, "source", DL_SOURCE_HASH, error);
    return status == DL_OK ? dl_results_add_fact(results, "flags", DL_BUILD_FLAGS, error) : status;
}

dl_status dl_facts_add(dl_results *results, const char *command, dl_error *error) {
    char date[64] = "";
    time_t now = time(NULL);
    struct tm utc;
    if (gmtime_r(&now, &utc))
        strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S UTC", &utc);
    dl_status status = add_build(results, error);
    if (status == DL_OK)
        status = add_machine(results, error);
    if (status == DL_OK)
        status = dl_results_add_fact(results, "date", date, error);
    return status == DL_OK && command ? dl_results_add_fact(results, "command", command, error)
                                      : status;
}
