/* The registry of observables. */
#include "observe/observables.h"

#include <math.h>
#include <string.h>

#include "driftlab/parameter.h"

/* --- energy, motion --------------------------------------------------------------------------- */

static dl_status measure_energy(dl_measuring *m, double *out, dl_error *error) {
    const dl_scene *scene = m->scene;
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    double kinetic = 0;
    size_t moving = 0;
    (void)error;
    for (size_t i = 0; i < n; i++) {
        moving += !scene->pinned[i];
        for (size_t c = 0; c < components && !scene->pinned[i]; c++) {
            const double v = m->y_all[(components + c) * n + i];
            kinetic += scene->inertia[i] / 2 * v * v;
        }
    }
    out[0] = kinetic / (double)moving;
    out[1] = kinetic;
    return DL_OK;
}

/* Mass-weighted root mean squares of v_n and of v_t less the mean rotation. */
static dl_status measure_motion(dl_measuring *m, double *out, dl_error *error) {
    const dl_scene *scene = m->scene;
    const size_t n = scene->particles;
    double *const radius = m->work, *const normal = radius + n, *const tangential = normal + n;
    double squares[2] = {0};
    dl_motion motion;
    (void)error;
    dl_observe_motion(scene, m->y_all, &motion);
    dl_observe_polar(scene, m->y_all, &motion, radius, normal, tangential);
    for (size_t i = 0; i < n; i++) {
        const double mass = scene->pinned[i] ? 0 : scene->inertia[i];
        const double about = tangential[i] - motion.angular_velocity * radius[i];
        squares[0] += mass * normal[i] * normal[i];
        squares[1] += mass * about * about;
    }
    const double values[] = {motion.centre[0],
                             motion.centre[1],
                             motion.velocity[0],
                             motion.velocity[1],
                             motion.angular_velocity,
                             motion.rigid_rotation,
                             sqrt(squares[0] / motion.mass),
                             sqrt(squares[1] / motion.mass)};
    for (size_t k = 0; k < sizeof values / sizeof *values; k++)
        out[k] = values[k];
    return DL_OK;
}

static dl_status motion_applies(dl_measuring *m, dl_error *error) {
    return m->scene->periods.present
               ? dl_fail(error, DL_INPUT,
                         "motion: found a periodic box, where nothing turns about the mass centre "
                         "(angular_velocity, rigid_rotation), expected a scene without periods")
               : DL_OK;
}

/* --- temperature, states ---------------------------------------------------------------------- */

static void add_to_classes(const dl_measuring *m, const double *values, size_t columns,
                           size_t column, double *out) {
    for (size_t i = 0; i < m->scene->particles; i++)
        if (!m->scene->pinned[i]) {
            const size_t k = m->class_of[i];
            out[k * columns + column] += values[i] / m->mass_class[k].particles;
        }
}

static dl_status measure_temperature(dl_measuring *m, double *out, dl_error *error) {
    const size_t columns = 3;
    (void)error;
    for (size_t k = 0; k < m->classes; k++) {
        out[k * columns] = m->mass_class[k].particles;
        out[k * columns + 1] = out[k * columns + 2] = m->mass_class[k].particles > 0 ? 0 : NAN;
    }
    dl_thermometer_read(m->measured, m->work);
    add_to_classes(m, m->work, columns, 1, out);
    dl_observe_heat(m->scene, m->y_all, m->work);
    for (size_t i = 0; i < m->scene->particles; i++)
        m->work[i] /= m->options.temperature->unit;
    add_to_classes(m, m->work, columns, 2, out);
    return DL_OK;
}

static dl_status measure_states(dl_measuring *m, double *out, dl_error *error) {
    const size_t columns = 3;
    (void)error;
    for (size_t k = 0; k < columns * m->classes; k++)
        out[k] = 0;
    dl_thermometer_read(m->state, m->work);
    for (size_t i = 0; i < m->scene->particles; i++) {
        if (m->scene->pinned[i])
            continue;
        const size_t k = m->class_of[i];
        out[k * columns + dl_observe_state(&m->mass_class[k].threshold, m->work[i])]++;
    }
    return DL_OK;
}

static dl_status states_apply(dl_measuring *m, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t k = 0; k < m->classes && !status; k++)
        status = dl_state_threshold_at(&dl_tr299_table4, m->mass_class[k].mass,
                                       &m->mass_class[k].threshold, error);
    return status;
}

/* --- escape ----------------------------------------------------------------------------------- */

static dl_status measure_escape(dl_measuring *m, double *out, dl_error *error) {
    const dl_escape_rule rule = {m->options.link, m->options.beyond};
    dl_escape result;
    const dl_status status =
        dl_observe_escape(m->model, m->y_all, &rule, m->escaped, &result, error);
    if (status)
        return status;
    out[0] = (double)result.particles;
    out[1] = (double)result.groups;
    out[2] = (double)result.system;
    return DL_OK;
}

dl_status dl_groups_apply(const dl_measuring *m, const char *what, dl_error *error) {
    if (m->whole->walls.present || m->whole->periods.present)
        return dl_fail(error, DL_INPUT, "%s: found walls or periods, expected a scene without them",
                       what);
    return isfinite(m->options.link)
               ? DL_OK
               : dl_fail(error, DL_INPUT,
                         "%s: found a pair law whose first piece never ends, expected a link to be "
                         "given",
                         what);
}

static dl_status escape_applies(dl_measuring *m, dl_error *error) {
    return dl_groups_apply(m, "escaped", error);
}

/* --- heights ---------------------------------------------------------------------------------- */

static dl_status measure_density(dl_measuring *m, double *out, dl_error *error) {
    const size_t count = m->bins.count;
    double *const particles = m->work, *const mass = particles + count;
    (void)error;
    dl_observe_density(m->scene, m->y_all, &m->bins, particles, mass);
    for (size_t k = 0; k < count; k++) {
        out[3 * k] = particles[k];
        out[3 * k + 1] = mass[k];
        out[3 * k + 2] = mass[k] / (m->bins.width * m->options.across);
    }
    return DL_OK;
}

static dl_status measure_depth(dl_measuring *m, double *out, dl_error *error) {
    const double floor_height = m->scene->walls.low[dl_height_axis(m->scene)]; /* depth_applies */
    dl_depth depth;
    const dl_status status = dl_observe_depth(m->scene, m->y_all, floor_height, &depth, error);
    if (status)
        return status;
    out[0] = depth.uniform;
    out[1] = depth.most;
    out[2] = depth.highest;
    return DL_OK;
}

static dl_status depth_applies(dl_measuring *m, dl_error *error) {
    const size_t axis = dl_height_axis(m->scene);
    return m->scene->walls.present && isfinite(m->scene->walls.low[axis])
               ? DL_OK
               : dl_fail(error, DL_INPUT,
                         "depth: found a scene without a floor, expected a wall below");
}

static dl_status measure_pressure(dl_measuring *m, double *out, dl_error *error) {
    const size_t count = m->bins.count;
    double *const interaction = m->work, *const kinetic = interaction + count;
    double *const weight = kinetic + count;
    const dl_status status = dl_observe_pressure(m->model, m->y_all, &m->bins, m->options.across,
                                                 interaction, kinetic, weight, error);
    for (size_t k = 0; k < count && !status; k++) {
        out[4 * k] = interaction[k];
        out[4 * k + 1] = kinetic[k];
        out[4 * k + 2] = interaction[k] + kinetic[k];
        out[4 * k + 3] = weight[k];
    }
    return status;
}

static dl_status pressure_applies(dl_measuring *m, dl_error *error) {
    if (!isfinite(m->options.across))
        return dl_fail(
            error, DL_INPUT,
            "pressure: found a scene that is open at its sides, expected walls, a period "
            "or a length across");
    return m->scene->periods.length[dl_height_axis(m->scene)] > 0
               ? dl_fail(error, DL_INPUT,
                         "pressure: found a scene that is periodic along the "
                         "height, expected one with a bottom")
               : DL_OK;
}

/* --- separation ------------------------------------------------------------------------------- */

static dl_status measure_separation(dl_measuring *m, double *out, dl_error *error) {
    static const size_t nearest[] = {1, 3, 6};
    dl_status status = DL_OK;
    for (size_t k = 0; k < sizeof nearest / sizeof *nearest && !status; k++)
        status = dl_observe_separation(m->scene, m->y_all, nearest[k], &out[k], error);
    return status;
}

static dl_status separation_applies(dl_measuring *m, dl_error *error) {
    return m->scene->particles > 1
               ? DL_OK
               : dl_fail(error, DL_INPUT, "separation: found one particle, expected several");
}

/* --- registry --------------------------------------------------------------------------------- */

static const dl_observable_entry entries[] = {
    {.row = {.name = "energy",
             .doc = "kinetic energy, in the scene's own frame",
             .rows = DL_ROWS_SYSTEM,
             .column = {"kinetic_per_particle", "kinetic"}},
     .measure = measure_energy},
    {.row = {.name = "motion",
             .doc =
                 "mass centre, mean angular velocity (TR299 (3.12)), mass-weighted rms of normal "
                 "and tangential velocity besides",
             .rows = DL_ROWS_SYSTEM,
             .column = {"centre_x", "centre_y", "velocity_x", "velocity_y", "angular_velocity",
                        "rigid_rotation", "normal_rms", "tangential_rms"}},
     .measure = measure_motion,
     .applies = motion_applies},
    {.row = {.name = "temperature",
             .doc = "by mass: mean temperature (TR299 (3.4)-(3.6)) and the instantaneous one",
             .rows = DL_ROWS_MASSES,
             .column = {"particles", "temperature", "instantaneous"}},
     .measure = measure_temperature},
    {.row =
         {.name = "states",
          .doc =
              "by mass: particles that are solid, liquid, gas by TR299's Table IV (temperatures of "
              "its program)",
          .rows = DL_ROWS_MASSES,
          .column = {"solid", "liquid", "gas"}},
     .measure = measure_states,
     .applies = states_apply},
    {.row = {.name = "escaped",
             .doc = "particles in groups that leave the heaviest group for good",
             .rows = DL_ROWS_SYSTEM,
             .column = {"particles", "groups", "system"}},
     .measure = measure_escape,
     .applies = escape_applies},
    {.row = {.name = "density",
             .doc = "by height: particles, mass, mass per area (volume in 3-D)",
             .rows = DL_ROWS_BINS,
             .column = {"particles", "mass", "density"}},
     .measure = measure_density},
    {.row = {.name = "depth",
             .doc = "above the floor: twice the mean height, height below which 95 % are, highest",
             .rows = DL_ROWS_SYSTEM,
             .column = {"uniform", "most", "highest"}},
     .measure = measure_depth,
     .applies = depth_applies},
    {.row = {.name = "separation",
             .doc = "mean distance to the nearest, the 3 and the 6 nearest others",
             .rows = DL_ROWS_SYSTEM,
             .column = {"nearest", "nearest_3", "nearest_6"}},
     .measure = measure_separation,
     .applies = separation_applies},
    {.row = {.name = "pressure",
             .doc = "by height: force per length across the middle of the bin, beside the weight "
                    "above it",
             .rows = DL_ROWS_BINS,
             .column = {"interaction", "kinetic", "pressure", "weight"}},
     .measure = measure_pressure,
     .applies = pressure_applies},
};

size_t dl_observable_count(void) {
    return sizeof entries / sizeof *entries;
}

const dl_observable_entry *dl_observable_entry_at(size_t index) {
    return &entries[index];
}

const dl_observable *dl_observable_at(size_t index) {
    return &entries[index].row;
}

dl_status dl_observable_find(const char *name, size_t *index, dl_error *error) {
    const char *names[sizeof entries / sizeof *entries + 1] = {NULL};
    for (size_t i = 0; i < dl_observable_count(); i++) {
        names[i] = entries[i].row.name;
        if (strcmp(name, names[i]) == 0) {
            *index = i;
            return DL_OK;
        }
    }
    const char *const closest = dl_closest_word(names, name);
    if (closest)
        return dl_fail(error, DL_INPUT, "unknown observable \"%s\"; did you mean \"%s\"?", name,
                       closest);
    return dl_fail(error, DL_INPUT,
                   "unknown observable \"%s\" (driftlab list observables names them)", name);
}
