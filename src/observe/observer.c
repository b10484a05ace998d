#include "observe/observer.h"

#include <math.h>
#include <stdlib.h>

/* Conserved quantities of one state. The kinetic energy is summed in long double: in a fast stream
 * it is 1e4 times the energy scale, and its last bit in double would be the largest error there. */
typedef struct quantities {
    dl_energy energy;
    long double kinetic;
    double linear[3], angular[3];
} quantities;

struct dl_observer {
    dl_model *model;
    double *y;        /* [2 * unknowns] */
    double *y_before; /* [2 * unknowns]: before the jump under way */
    double *y_all;    /* [2 * dimension * particles]; NULL: nothing is pinned, and y is it */
    double *own_y;    /* both in a frame of the method's own; NULL: none yet */
    quantities start; /* at t = 0 */
    bool at_start;    /* no sample has been taken yet: it is of the start, in y and y_all */
    long double ledger;
    long double impulse[3], angular_impulse[3]; /* that the walls have taken */
    double gravity_force[3];
    bool contacts; /* a wall's steady force has acted */
    bool books;    /* jumps are booked */
    bool missed;   /* a jump was not */
};

dl_status dl_observer_create(const dl_scene *scene, bool ledger, dl_observer **observer,
                             dl_error *error) {
    *observer = NULL;
    dl_observer *created = calloc(1, sizeof *created);
    if (!created)
        return dl_fail_memory(error, "the observation of a run");
    created->books = ledger;
    dl_status status = dl_model_create(scene, &created->model, error);
    if (status) {
        dl_observer_free(created);
        return status;
    }
    const dl_model *model = created->model;
    created->y = malloc(2 * model->unknowns * sizeof *created->y);
    created->y_before = malloc(2 * model->unknowns * sizeof *created->y_before);
    if (model->has_pins)
        created->y_all =
            malloc(2 * (size_t)model->dimension * model->particles * sizeof *created->y_all);
    if (!created->y || !created->y_before || (model->has_pins && !created->y_all)) {
        dl_observer_free(created);
        return dl_fail_memory(error, "the observation of a run");
    }
    dl_model_gravity_force(model, created->gravity_force);
    *observer = created;
    return DL_OK;
}

void dl_observer_free(dl_observer *observer) {
    if (!observer)
        return;
    dl_model_free(observer->model);
    free(observer->y);
    free(observer->y_before);
    free(observer->y_all);
    free(observer->own_y);
    free(observer);
}

static long double kinetic_energy(const dl_scene *scene, const double *y_all,
                                  const double frame[3]) {
    const size_t components = (size_t)scene->dimension;
    const double *velocity = y_all + components * scene->particles;
    long double sum = 0;
    for (size_t i = 0; i < scene->particles; i++) {
        long double square = 0;
        for (size_t k = 0; k < components; k++) {
            const long double v = (long double)velocity[k * scene->particles + i] + frame[k];
            square += v * v;
        }
        sum += 0.5L * scene->inertia[i] * square;
    }
    return sum;
}

/* A method that needs a force to tell its state takes it from the observer's model. */
static dl_status take_state(dl_observer *observer, dl_method *method, double *y, dl_error *error) {
    dl_model *integrated = method->model;
    method->model = observer->model;
    const dl_status status = dl_method_state(method, y, error);
    method->model = integrated;
    return status;
}

/* The state y over all particles: y itself where nothing is pinned, or else y_all. */
static const double *over_all(const dl_model *model, const double *y, double *y_all) {
    if (!model->has_pins)
        return y;
    dl_model_expand(model, y, y_all);
    return y_all;
}

/* Of a state y in a frame that moves with `frame`; y_all has room for it over all particles. */
static dl_status measure_in(dl_observer *observer, const double *y, double *y_all,
                            const double frame[3], quantities *measured, dl_error *error) {
    const dl_status status = dl_model_energy(observer->model, y, &measured->energy, error);
    if (status)
        return status;
    measured->kinetic =
        kinetic_energy(observer->model->scene, over_all(observer->model, y, y_all), frame);
    if (dl_model_conserves_linear_momentum(observer->model) ||
        dl_model_conserves_angular_momentum(observer->model))
        dl_model_momentum(observer->model, y, measured->linear, measured->angular);
    return DL_OK;
}

/* The method's own state, where it keeps one in a frame that the energies look the same in: far
 * from the scene's origin it has digits that y has lost. */
static dl_status measure_own_frame(dl_observer *observer, const dl_method *method,
                                   quantities *measured, dl_error *error) {
    const dl_model *model = observer->model;
    const size_t all = model->has_pins ? 2 * (size_t)model->dimension * model->particles : 0;
    double frame[3];
    if (!observer->own_y)
        observer->own_y = malloc((2 * model->unknowns + all) * sizeof *observer->own_y);
    if (!observer->own_y)
        return dl_fail_memory(error, "the observation of a run");
    method->row->ops->own_frame(method, observer->own_y, frame);
    const dl_status status = measure_in(
        observer, observer->own_y, observer->own_y + 2 * model->unknowns, frame, measured, error);
    if (status)
        return status;
    for (size_t k = 0; k < 3; k++)
        measured->linear[k] += dl_model_inertia(model) * frame[k];
    measured->energy.total += (double)measured->kinetic - measured->energy.kinetic;
    measured->energy.kinetic = (double)measured->kinetic;
    return DL_OK;
}

static dl_status measure(dl_observer *observer, dl_method *method, quantities *measured,
                         dl_error *error) {
    static const double at_rest[3] = {0};
    const dl_model *model = observer->model;
    const dl_status status = take_state(observer, method, observer->y, error);
    if (status)
        return status;
    if (!method->row->ops->own_frame || !dl_model_is_galilean_invariant(model) ||
        model->has_gravity)
        return measure_in(observer, observer->y, observer->y_all, at_rest, measured, error);
    over_all(model, observer->y, observer->y_all);
    return measure_own_frame(observer, method, measured, error);
}

/* E(to) - E(from), without the cancellation of the totals. */
static long double energy_change(const quantities *from, const quantities *to) {
    return (to->kinetic - from->kinetic) + ((long double)to->energy.pair - from->energy.pair) +
           ((long double)to->energy.gravity - from->energy.gravity);
}

dl_status dl_observer_begin(dl_observer *observer, dl_method *method, dl_run_summary *summary,
                            dl_error *error) {
    dl_status status = measure(observer, method, &observer->start, error);
    if (!status)
        status = dl_model_energy_scale(observer->model, observer->y, &summary->energy_scale, error);
    if (status)
        return status;
    if (!isfinite(observer->start.energy.total))
        return dl_fail(error, DL_UNSTABLE, "the energy of the initial state is not finite");
    dl_model_momentum_scales(observer->model, observer->y, &summary->momentum_scale,
                             &summary->angular_momentum_scale);
    observer->at_start = true;
    return DL_OK;
}

static double momentum_error(const double now[3], const double start[3], const long double taken[3],
                             const double force[3], double time) {
    long double square = 0;
    for (size_t k = 0; k < 3; k++) {
        const long double error =
            (long double)now[k] - start[k] + taken[k] - (long double)force[k] * (long double)time;
        square += error * error;
    }
    return (double)sqrtl(square);
}

dl_status dl_observer_sample(dl_observer *observer, dl_method *method, double time,
                             dl_sample *sample, dl_error *error) {
    static const double no_torque[3] = {0};
    quantities now = observer->start;
    const dl_status status = observer->at_start ? DL_OK : measure(observer, method, &now, error);
    observer->at_start = false;
    if (status)
        return status;
    const dl_model *model = observer->model;
    const quantities *start = &observer->start;
    sample->time = time;
    sample->energy = now.energy;
    sample->ledger = (double)observer->ledger;
    sample->energy_error = (double)(energy_change(start, &now) + observer->ledger);
    sample->momentum_error = dl_model_conserves_linear_momentum(model) && !observer->contacts
                                 ? momentum_error(now.linear, start->linear, observer->impulse,
                                                  observer->gravity_force, time)
                                 : NAN;
    sample->angular_momentum_error =
        dl_model_conserves_angular_momentum(model) && !observer->contacts
            ? momentum_error(now.angular, start->angular, observer->angular_impulse, no_torque,
                             time)
            : NAN;
    if (observer->missed)
        sample->ledger = sample->energy_error = sample->momentum_error =
            sample->angular_momentum_error = NAN;
    sample->y_all = observer->model->has_pins ? observer->y_all : observer->y;
    return DL_OK;
}

dl_status dl_observer_before_jump(dl_observer *observer, dl_method *method, dl_error *error) {
    if (!observer->books) {
        observer->missed = true;
        return DL_OK;
    }
    return take_state(observer, method, observer->y_before, error);
}

dl_status dl_observer_after_jump(dl_observer *observer, dl_method *method, dl_error *error) {
    dl_energy energy;
    double linear[3], angular[3] = {0};
    const bool turns = dl_model_conserves_angular_momentum(observer->model);
    if (!observer->books)
        return DL_OK;
    dl_status status = take_state(observer, method, observer->y, error);
    if (!status)
        status = dl_model_energy_change(observer->model, observer->y_before, observer->y, &energy,
                                        error);
    if (status)
        return status;
    dl_model_momentum_change(observer->model, observer->y_before, observer->y, linear,
                             turns ? angular : NULL);
    observer->ledger -= (long double)energy.kinetic + energy.pair + energy.gravity;
    for (size_t k = 0; k < 3; k++) {
        observer->impulse[k] -= linear[k];
        observer->angular_impulse[k] -= angular[k];
    }
    return DL_OK;
}

void dl_observer_contact(dl_observer *observer) {
    observer->contacts = true;
}

double dl_observer_initial_energy(const dl_observer *observer) {
    return observer->start.energy.total;
}
