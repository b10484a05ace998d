/* driftlab measure: one unit of a study of any kind but work-precision, in the foreground. */
#include "cli/command.h"
#include "cli/finding.h"
#include "cli/outcome.h"
#include "cli/settings.h"

typedef struct measure_values {
    char *method;
    double t_end, sample, time_limit;
    bool json;
} measure_values;

static const dl_parameter options[] = {
    CLI_OPTION_METHOD(measure_values),
    CLI_OPTION_T_END(measure_values),
    CLI_OPTION_POSITIVE(measure_values, "sample", sample, "X",
                        "time between samples (default: as many as the kind's studies have)"),
    CLI_OPTION_TIME_LIMIT(measure_values, "CPU time of one run of it (default: none)"),
    CLI_OPTION_JSON(measure_values),
};

static cli_exit measure(const cli_input *input) {
    const measure_values *values = input->values;
    const cli_measurement asked = {.kind = input->word[0],
                                   .scene = input->word[1],
                                   .method = values->method,
                                   .end = values->t_end,
                                   .sample = values->sample,
                                   .seconds = values->time_limit};
    dl_finding finding = {0};
    dl_error error = {""};
    dl_status status = cli_measure(input, &asked, &finding, &error);
    if (!status && values->json) {
        status = cli_finding_json(&finding, stdout, &error);
    } else if (!status) {
        cli_finding_summary(&finding, stdout);
        cli_finding_table(&finding, stdout);
    }
    if (!status && finding.status)
        status = dl_fail(&error, finding.status, "%s", finding.message);
    dl_finding_release(&finding);
    return cli_finish(status, &error);
}

static const cli_repeated set = {"set", "KEY=VALUE", "an option of the method or of the kind",
                                 true};

const cli_command cli_command_measure = {
    .name = "measure",
    .arguments = "KIND SCENE",
    .summary = "ask a study's question (drift ...) of one method on one scene",
    .details = "What a study of that kind finds for one of its cases: verdict, reason, quantities\n"
               "and table. driftlab help study describes the kinds and their settings. The exit\n"
               "status is 0 whatever the verdict.\n",
    .least_words = 2,
    .most_words = 2,
    .repeated = &set,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(measure_values),
    .run = measure,
};
