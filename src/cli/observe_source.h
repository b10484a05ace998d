/* Where the frames that are observed come from: a trajectory, or a scene's initial state. */
#ifndef DL_CLI_OBSERVE_SOURCE_H
#define DL_CLI_OBSERVE_SOURCE_H

#include "cli/command.h"
#include "driftlab/trajectory.h"

/* Which frames: one of `last`, `time` (INFINITY: not given), `step` (-1: not given), or every
 * `every`-th of those between two times. */
typedef struct cli_choice {
    bool last;
    double time, from, to;
    long step, every;
} cli_choice;

typedef struct cli_source {
    const char *file;
    dl_scene *scene;
    dl_frames *frames;         /* NULL: a scene */
    size_t count;              /* frames in all */
    size_t first, last, every; /* those that are observed */
    double *y_all;             /* the one that was read last */
} cli_source;

/* `scene`: file of the trajectory's scene; NULL: it holds its own. Close also on failure. */
dl_status cli_source_open(const cli_input *input, const char *scene, cli_source *source,
                          dl_error *error);
void cli_source_close(cli_source *source);

dl_status cli_source_choose(cli_source *source, const cli_choice *choice, dl_error *error);

static inline bool cli_source_observes(const cli_source *source, size_t number) {
    return number >= source->first && number <= source->last &&
           (number - source->first) % source->every == 0;
}
static inline size_t cli_source_observed(const cli_source *source) {
    return (source->last - source->first) / source->every + 1;
}

double cli_source_time(const cli_source *source, size_t number);
/* -1: a scene, which has made none. */
long cli_source_step(const cli_source *source, size_t number);
dl_status cli_source_read(cli_source *source, size_t number, dl_error *error);

/* Range of the heights in the frames that are observed. */
dl_status cli_source_heights(cli_source *source, double *lowest, double *highest, dl_error *error);

#endif
