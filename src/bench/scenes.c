#include <math.h>
#include <stdio.h>

#include "bench/bench.h"

/* TR171's law with alpha = 7, beta = 10, p = q = 1, as in the stream: its particles at 1.2, where
 * 1.5^(1/3) is at rest, going slowly round each other. */
static double position[] = {0.6, -0.6, 0, 0}, velocity[] = {0, 0, 0.1, -0.1}, mass[] = {1, 1};
static char name[] = "pair", text[] = "";
static bool nothing[] = {false, false};

static const dl_scene pair = {
    .name = name,
    .text = text,
    .dimension = 2,
    .particles = 2,
    .position = position,
    .velocity = velocity,
    .inertia = mass,
    .coupling = mass,
    .feels_gravity = nothing,
    .pinned = nothing,
    .law = {.pieces = 1,
            .piece = {{.until = INFINITY,
                       .terms = 2,
                       .term = {{.coefficient = -6, .power = 7},
                                {.coefficient = 9, .power = 10}}}}},
    .step = 0.02,
    .end = 200,
};

dl_status dl_bench_scenes_read(const char *studies, dl_bench_scenes *scenes, dl_error *error) {
    static const char *const names[] = {"stream/stream.yaml", "swirl/swirl.yaml",
                                        "drop/settled.yaml"};
    *scenes = (dl_bench_scenes){.pair = pair, .pair_parts = pair};
    dl_scene **const to[] = {&scenes->stream, &scenes->swirl, &scenes->fluid};
    for (size_t k = 0; k < sizeof to / sizeof *to; k++) {
        snprintf(scenes->file[k], sizeof scenes->file[k], "%s/%s", studies, names[k]);
        const dl_status status = dl_scene_read(scenes->file[k], to[k], error);
        if (status) {
            dl_bench_scenes_release(scenes);
            return status;
        }
    }
    scenes->stream_parts = *scenes->stream;
    scenes->stream_parts.law.piece[0].part[0] = DL_PART_SLOW;
    scenes->pair_parts.law.piece[0].part[0] = DL_PART_SLOW;
    return DL_OK;
}

void dl_bench_scenes_release(dl_bench_scenes *scenes) {
    dl_scene_free(scenes->stream);
    dl_scene_free(scenes->swirl);
    dl_scene_free(scenes->fluid);
    scenes->stream = scenes->swirl = scenes->fluid = NULL;
}
