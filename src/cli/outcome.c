#include "cli/outcome.h"

#include "cli/terminal.h"

cli_exit cli_exit_of(dl_status status) {
    static const cli_exit exits[] = {
        [DL_OK] = CLI_OK,
        [DL_UNSTABLE] = CLI_FAILED,
        [DL_NONLINEAR_FAILURE] = CLI_FAILED,
        [DL_STEP_FAILURE] = CLI_FAILED,
        [DL_TIMEOUT] = CLI_FAILED,
        [DL_INTERRUPTED] = CLI_INTERRUPTED,
        [DL_INPUT] = CLI_BAD_INPUT,
        [DL_IO] = CLI_IO,
        [DL_MEMORY] = CLI_FAILED,
        [DL_ERROR] = CLI_FAILED,
    };
    return (size_t)status < sizeof exits / sizeof *exits ? exits[status] : CLI_FAILED;
}

cli_exit cli_finish(dl_status status, const dl_error *error) {
    if (status)
        cli_complain(error->message);
    return cli_exit_of(status);
}
