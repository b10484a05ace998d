/* A reference in extended precision: three trajectories and their growth, in a process of its own.
 * What long double does not resolve, quad precision does. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/reference.h"
#include "observe/stopwatch.h"
#include "reference/horizon.h"
#include "reference/trajectory.h"
#include "study/child.h"
#include "study/plan.h"

/* What quad precision costs, in units of long double: measured from 30 to 80. */
static const double quad_cost = 60;

enum { least_parts = 64, most_parts = 100000, steps_a_part = 20 };

typedef enum part { SOLUTION, LOOSER, OTHER_METHOD, GROWTH, PARTS } part;

/* The checks take other steps, so that they round in another way. */
static const dl_extended_setup setups[] = {
    [SOLUTION] = {.method = DL_TAYLOR, .tolerance = 0.25, .stride = 2},
    [LOOSER] = {.method = DL_TAYLOR, .tolerance = 16, .stride = 1.3},
    [OTHER_METHOD] = {.method = DL_GAUSS, .tolerance = 0.25, .stride = 1.7},
};

static const char *const part_names[PARTS] = {
    [SOLUTION] = "Taylor series",
    [LOOSER] = "Taylor series with a looser tolerance",
    [OTHER_METHOD] = "Gauss-Legendre collocation",
    [GROWTH] = "growth of displacements",
};

/* Before the states, high then low, or the growth. */
typedef struct message {
    part part;
    dl_status status;
    dl_error error;
    double seconds;
    dl_extended_counts counts;
} message;

typedef struct work {
    const dl_scene *scene;
    const dl_reference_request *request;
    const dl_extended_ops *ops;
    size_t length;       /* of a state */
    unsigned long steps; /* of the solution, once that is there */
    /* parent */
    dl_reference *reference;
    double apart[PARTS];             /* own error by each check alone */
    double *growth;                  /* NULL: not measured */
    char no_growth[DL_MESSAGE_SIZE]; /* why */
    double *final;                   /* [2 * length] */
    unsigned received;
} work;

static size_t states_size(const work *on) {
    return 2 * (on->request->intervals + 1) * on->length;
}

/* Of an interval, over which growth is followed: so many that no part multiplies a displacement by
 * much. */
static size_t parts_of(const work *on) {
    const size_t intervals = on->request->intervals;
    size_t parts = on->steps / steps_a_part;
    parts = parts > least_parts ? parts : least_parts;
    parts = parts < most_parts ? parts : most_parts;
    return (parts + intervals - 1) / intervals;
}

static size_t growth_size(const work *on) {
    return parts_of(on) * on->request->intervals + 1;
}

/* --- in the child ----------------------------------------------------------------------------- */

static void run_part(work *on, part which, message *sent, double *data) {
    const dl_reference_request *request = on->request;
    const double began = dl_cpu_clock();
    const dl_extended_limits limits = {.seconds = request->seconds, .began = began};
    *sent = (message){.part = which};
    if (which == GROWTH) {
        sent->status = dl_extended_growth(on->scene, &limits, on->reference->length, request->end,
                                          growth_size(on) - 1, data, &sent->error);
    } else {
        dl_extended_setup setup = setups[which];
        setup.limits = limits;
        sent->status =
            dl_extended_trajectory(on->ops, on->scene, &setup, request->end, request->intervals,
                                   data, data + states_size(on) / 2, &sent->counts, &sent->error);
    }
    if (which == SOLUTION)
        on->steps = sent->counts.steps;
    sent->seconds = dl_cpu_clock() - began;
}

static void run_and_send(work *on, part which, int pipe) {
    const size_t doubles = which == GROWTH ? growth_size(on) : states_size(on);
    char *bytes = calloc(1, sizeof(message) + doubles * sizeof(double));
    message failed = {.part = which, .status = DL_MEMORY};
    if (!bytes) {
        dl_fail_memory(&failed.error, "a reference");
        dl_child_send(pipe, &failed, sizeof failed);
        return;
    }
    message *sent = (message *)(void *)bytes;
    run_part(on, which, sent, (double *)(void *)(bytes + sizeof *sent));
    dl_child_send(pipe, bytes, sizeof *sent + doubles * sizeof(double));
    free(bytes);
}

static void work_on_reference(void *context, int pipe) {
    for (part which = SOLUTION; which < PARTS; which++)
        run_and_send(context, which, pipe);
}

/* --- in the parent ---------------------------------------------------------------------------- */

static void take_solution(work *on, const double *high, const double *low) {
    dl_reference *reference = on->reference;
    const size_t block = on->length / 2;
    for (size_t i = 0; i < reference->samples; i++) {
        reference->time[i] = dl_reference_time(on->request->end, on->request->intervals, i);
        memcpy(reference->position + i * block, high + i * on->length, block * sizeof *high);
        memcpy(reference->position_low + i * block, low + i * on->length, block * sizeof *low);
    }
    const size_t last = on->request->intervals * on->length;
    memcpy(on->final, high + last, on->length * sizeof *high);
    memcpy(on->final + on->length, low + last, on->length * sizeof *low);
}

/* A growth that could not be followed is no reason to have no reference. */
static void take_growth(work *on, const message *found, const double *growth) {
    const size_t count = growth_size(on);
    on->growth = found->status == DL_OK ? malloc(count * sizeof *growth) : NULL;
    if (on->growth)
        memcpy(on->growth, growth, count * sizeof *growth);
    else
        snprintf(on->no_growth, sizeof on->no_growth, "; %s was not followed: %.800s",
                 part_names[GROWTH], found->error.message);
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    work *on = context;
    message found;
    if (size < sizeof found)
        return dl_fail(error, DL_ERROR, "the reference's process sent too little");
    memcpy(&found, data, sizeof found);
    const double *values = (const double *)(const void *)((const char *)data + sizeof found);
    const double *low = values + states_size(on) / 2;
    on->received++;
    if (found.part == GROWTH) {
        take_growth(on, &found, values);
        return DL_OK;
    }
    if (found.status != DL_OK)
        return dl_fail(error, found.status, "%s in %s: %.800s", part_names[found.part],
                       on->ops->name, found.error.message);
    if (found.part == SOLUTION) {
        on->reference->seconds = found.seconds;
        on->steps = found.counts.steps;
        take_solution(on, values, low);
        return DL_OK;
    }
    on->apart[found.part] = dl_reference_take_check(on->scene, on->reference, values, low);
    return DL_OK;
}

static void tick(void *context) {
    const dl_reference_request *request = ((const work *)context)->request;
    if (request->on_tick)
        request->on_tick(request->context);
}

static dl_status run_child(work *on, dl_error *error) {
    const dl_child_work child = {
        .work = work_on_reference,
        .receive = receive,
        .tick = tick,
        .context = on,
        .seconds = on->request->seconds,
        .memory = on->request->memory,
        .interrupt = on->request->interrupt,
    };
    const dl_status status = dl_child_run(&child, error);
    if (status == DL_OK && on->received != PARTS)
        return dl_fail(error, DL_ERROR, "its process ended without a result");
    return status;
}

static dl_status allocate(work *on, dl_error *error) {
    const size_t samples = on->request->intervals + 1, block = on->length / 2;
    on->final = calloc(2 * on->length, sizeof *on->final);
    *on->reference = (dl_reference){
        .precision = dl_text("%s", on->ops->name),
        .note = dl_text("%s", ""),
        .samples = samples,
        .particles = on->scene->particles,
        .dimension = on->scene->dimension,
        .time = calloc(samples, sizeof(double)),
        .sample_error = calloc(samples, sizeof(double)),
        .growth = calloc(samples, sizeof(double)),
        .position = calloc(samples * block, sizeof(double)),
        .position_low = calloc(samples * block, sizeof(double)),
    };
    const dl_reference *made = on->reference;
    return made->precision && made->note && made->time && made->sample_error && made->growth &&
                   made->position && made->position_low && on->final
               ? DL_OK
               : dl_fail_memory(error, "a reference");
}

static dl_status describe(work *on, dl_error *error) {
    on->reference->description =
        dl_text("%s in %s precision, checked with a looser tolerance (%.2g) and by %s (%.2g)%s",
                part_names[SOLUTION], on->ops->name, on->apart[LOOSER], part_names[OTHER_METHOD],
                on->apart[OTHER_METHOD], on->no_growth);
    return on->reference->description ? DL_OK : dl_fail_memory(error, "a reference");
}

static void give_final(const work *on) {
    const dl_reference_request *request = on->request;
    if (!request->final_high)
        return;
    memcpy(request->final_high, on->final, on->length * sizeof *on->final);
    memcpy(request->final_low, on->final + on->length, on->length * sizeof *on->final);
}

/* In one precision. On failure nothing is left in *made. */
static dl_status compute(const dl_scene *scene, const dl_reference_request *request,
                         const dl_extended_ops *ops, dl_reference *made, dl_error *error) {
    work on = {.scene = scene,
               .request = request,
               .ops = ops,
               .length = 2 * (size_t)scene->dimension * scene->particles,
               .reference = made};
    dl_status status = allocate(&on, error);
    if (status == DL_OK)
        status = dl_reference_length(scene, &made->length, error);
    if (status == DL_OK)
        status = run_child(&on, error);
    if (status == DL_OK)
        status = describe(&on, error);
    if (status == DL_OK) {
        dl_reference_take_rounding(scene, made, ops->epsilon, on.steps);
        dl_reference_set_horizon(scene, made, on.growth, parts_of(&on), ops->epsilon);
        give_final(&on);
    } else {
        dl_reference_release(made);
    }
    free(on.growth);
    free(on.final);
    return status;
}

bool dl_reference_quad_is_too_slow(const dl_reference *in_long_double, double seconds, char *text,
                                   size_t size) {
    const double needed = quad_cost * in_long_double->seconds;
    snprintf(text, size, "quad precision would take about %.2g CPU seconds, the limit is %g",
             needed, seconds);
    return needed > seconds;
}

/* Quad in the place of long double; where that cannot be had, the note says why. */
static dl_status improve(const dl_scene *scene, const dl_reference_request *request,
                         dl_reference *made, dl_error *error) {
    dl_reference better;
    dl_error why = {""};
    char text[DL_MESSAGE_SIZE];
    dl_status status = DL_OK;
    const bool too_slow = dl_reference_quad_is_too_slow(made, request->seconds, text, sizeof text);
    if (!too_slow) {
        status = compute(scene, request, &dl_extended_quad, &better, &why);
        snprintf(text, sizeof text, "%.900s", why.message);
    }
    if (status == DL_INTERRUPTED || status == DL_MEMORY)
        return dl_fail(error, status, "%s", why.message);
    if (!too_slow && status == DL_OK) {
        dl_reference_release(made);
        *made = better;
        return DL_OK;
    }
    free(made->note);
    made->note = dl_text("%s", text);
    return made->note ? DL_OK : dl_fail_memory(error, "a reference");
}

/* Past the horizon no error is shown, however good the reference. */
static bool is_not_enough(const dl_reference *made, const dl_reference_request *request) {
    return request->precision == DL_PRECISION_AUTO && request->wanted > 0 &&
           made->error > request->wanted && made->horizon == 0;
}

dl_status dl_reference_compute(const dl_scene *scene, const dl_reference_request *request,
                               dl_reference *made, dl_error *error) {
    if (request->precision == DL_PRECISION_QUAD)
        return compute(scene, request, &dl_extended_quad, made, error);
    dl_status status = compute(scene, request, &dl_extended_long_double, made, error);
    if (status == DL_OK && is_not_enough(made, request)) {
        status = improve(scene, request, made, error);
        if (status != DL_OK)
            dl_reference_release(made);
    }
    return status;
}
