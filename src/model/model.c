#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "model/private.h"

static bool all_one(const double *values, const size_t *order, size_t count) {
    for (size_t k = 0; k < count; k++)
        if (values[order[k]] != 1)
            return false;
    return true;
}

static void order_particles(dl_model *model) {
    const dl_scene *scene = model->scene;
    size_t *order = model->priv->order, next = 0;
    for (int pinned = 0; pinned <= 1; pinned++) {
        for (size_t i = 0; i < scene->particles; i++)
            if (scene->pinned[i] == (pinned == 1))
                order[next++] = i;
        if (!pinned)
            model->moving = next;
    }
    model->has_pins = model->moving < model->particles || (scene->keep & DL_KEEP_PINS);
    model->unknowns = (size_t)model->dimension * model->moving;
}

/* The scene's law, or those of its species' pairs. */
static dl_status fill_laws(dl_model *model, dl_error *error) {
    const dl_scene *scene = model->scene;
    struct dl_model_private *priv = model->priv;
    const dl_pair_law *source = scene->species > 0 ? scene->species_law : &scene->law;
    size_t species = scene->species > 0 ? scene->species : 1;
    priv->law = calloc(species * species, sizeof *priv->law);
    if (species > 1)
        priv->species_of = malloc(model->particles * sizeof *priv->species_of);
    if (!priv->law || (species > 1 && !priv->species_of))
        return dl_fail_memory(error, "the model's pair laws");
    dl_pair_problem *problem = &priv->problem;
    for (size_t k = 0; k < species * species; k++) {
        dl_law *law = &priv->law[k];
        const dl_pair_law own = priv->whole ? dl_pair_law_part(&source[k], priv->which) : source[k];
        dl_law_prepare(&own, law);
        law->integer &= !(scene->keep & DL_KEEP_REAL_POWERS);
        if (law->pieces > 0)
            problem->reach = fmax(problem->reach, law->until[law->pieces - 1]);
        for (int piece = 0; piece < law->pieces; piece++)
            model->locates_crossings |= law->located[piece];
    }
    for (size_t k = 0; priv->species_of && k < model->particles; k++)
        priv->species_of[k] = scene->species_of[priv->order[k]];
    problem->law = priv->law;
    problem->species = species;
    problem->species_of = priv->species_of;
    return DL_OK;
}

static dl_status fill_particles(dl_model *model, dl_error *error) {
    const dl_scene *scene = model->scene;
    struct dl_model_private *priv = model->priv;
    size_t moving = model->moving, particles = model->particles;
    priv->inertia = malloc((moving + 1) * sizeof(double));
    if (!priv->inertia)
        return dl_fail_memory(error, "the model's inertias");
    for (size_t k = 0; k < moving; k++)
        priv->inertia[k] = scene->inertia[priv->order[k]];
    if ((scene->keep & DL_KEEP_INERTIA) || !all_one(scene->inertia, priv->order, moving)) {
        priv->inverse_inertia = malloc((moving + 1) * sizeof(double));
        if (!priv->inverse_inertia)
            return dl_fail_memory(error, "the model's inertias");
        for (size_t k = 0; k < moving; k++)
            priv->inverse_inertia[k] = 1 / priv->inertia[k];
    }
    const bool couplings =
        (scene->keep & DL_KEEP_COUPLING) || !all_one(scene->coupling, priv->order, particles);
    if (priv->problem.reach > 0 && couplings) {
        priv->coupling = calloc(particles + DL_VECTOR_PAD, sizeof(double));
        if (!priv->coupling)
            return dl_fail_memory(error, "the model's couplings");
        for (size_t k = 0; k < particles; k++)
            priv->coupling[k] = scene->coupling[priv->order[k]];
    }
    return DL_OK;
}

static dl_status fill_gravity(dl_model *model, dl_error *error) {
    const dl_scene *scene = model->scene;
    size_t feel = 0;
    for (size_t k = 0; k < model->moving; k++)
        feel += scene->feels_gravity[model->priv->order[k]];
    bool any = scene->gravity[0] != 0 || scene->gravity[1] != 0 || scene->gravity[2] != 0;
    any &= !model->priv->whole || model->priv->which == DL_PART_SLOW;
    model->has_gravity = any && feel > 0;
    const bool masked = (scene->keep & DL_KEEP_GRAVITY_MASK) || feel < model->moving;
    if (!model->has_gravity || !masked)
        return DL_OK;
    double *mask = model->priv->gravity_mask = malloc((model->moving + 1) * sizeof(double));
    if (!mask)
        return dl_fail_memory(error, "the gravity mask");
    for (size_t k = 0; k < model->moving; k++)
        mask[k] = scene->feels_gravity[model->priv->order[k]];
    return DL_OK;
}

/* What methods need not ask for at every step. */
static void classify_force(dl_model *model) {
    const bool alone = !model->kernel && model->has_gravity;
    model->has_force = model->kernel || model->has_gravity;
    model->is_uniform = alone && !model->priv->gravity_mask && !model->locates_hits;
}

/* Full blocks in which the pinned particles stand still. */
static dl_status fill_pins(dl_model *model, dl_error *error) {
    if (!model->has_pins)
        return DL_OK;
    struct dl_model_private *priv = model->priv;
    size_t n = model->particles, block = (size_t)model->dimension * n;
    priv->place = calloc(block, sizeof(double));
    priv->shift = calloc(block, sizeof(double));
    priv->pair_force = calloc(block, sizeof(double));
    if (!priv->place || !priv->shift || !priv->pair_force)
        return dl_fail_memory(error, "the pinned particles");
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = model->moving; k < n; k++)
            priv->place[c * n + k] = model->scene->position[c * n + priv->order[k]];
    return DL_OK;
}

static void fill_box(dl_model *model) {
    struct dl_model_private *priv = model->priv;
    if (!model->has_periods)
        return;
    for (int c = 0; c < model->dimension; c++) {
        double length = model->scene->periods.length[c];
        priv->box.length[c] = length;
        priv->box.inverse[c] = length > 0 ? 1 / length : 0;
    }
    priv->problem.box = &priv->box;
}

static dl_status fill_kernel(dl_model *model, dl_error *error) {
    struct dl_model_private *priv = model->priv;
    dl_pair_problem *problem = &priv->problem;
    priv->vector = dl_vector_best();
    if (problem->reach == 0)
        return DL_OK;
    problem->dimension = model->dimension;
    problem->particles = model->particles;
    problem->moving = model->moving;
    problem->coupling = priv->coupling;
    problem->skin = model->scene->skin;
    problem->tree_error = model->scene->tree_error;
    fill_box(model);
    return dl_kernel_create(problem, model->scene->kernel, &model->kernel, error);
}

dl_status dl_model_create_part(const dl_scene *scene, dl_model *whole, dl_part which,
                               dl_model **model, dl_error *error) {
    *model = NULL;
    dl_model *made = calloc(1, sizeof *made);
    if (!made)
        return dl_fail_memory(error, "a model");
    made->scene = scene;
    made->dimension = scene->dimension;
    made->particles = scene->particles;
    made->has_walls = scene->walls.present;
    made->locates_hits = scene->walls.present && scene->walls.rule == DL_LOCATED;
    made->has_periods = scene->periods.present;
    made->has_radiation = scene->radiation.present;
    made->acceleration = dl_model_accelerate;
    made->discrete_acceleration = dl_model_accelerate_quotient;
    made->part_acceleration = dl_model_accelerate_part;
    made->priv = calloc(1, sizeof *made->priv);
    dl_status status = made->priv ? DL_OK : dl_fail_memory(error, "a model");
    if (status == DL_OK) {
        made->priv->whole = whole;
        made->priv->which = which;
        made->priv->order = malloc(scene->particles * sizeof(size_t));
        if (!made->priv->order)
            status = dl_fail_memory(error, "a model");
    }
    if (status == DL_OK) {
        order_particles(made);
        status = fill_laws(made, error);
    }
    status = status == DL_OK ? fill_particles(made, error) : status;
    status = status == DL_OK ? fill_gravity(made, error) : status;
    status = status == DL_OK ? fill_pins(made, error) : status;
    status = status == DL_OK ? fill_kernel(made, error) : status;
    if (status != DL_OK) {
        dl_model_free(made);
        return status;
    }
    classify_force(made);
    *model = made;
    return DL_OK;
}

dl_status dl_model_create(const dl_scene *scene, dl_model **model, dl_error *error) {
    return dl_model_create_part(scene, NULL, DL_PART_FAST, model, error);
}

void dl_model_free(dl_model *model) {
    if (!model)
        return;
    dl_kernel_destroy(model->kernel);
    struct dl_model_private *priv = model->priv;
    if (priv) {
        dl_model_free_parts(model);
        free(priv->order);
        free(priv->law);
        free(priv->species_of);
        free(priv->coupling);
        free(priv->inertia);
        free(priv->inverse_inertia);
        free(priv->gravity_mask);
        free(priv->place);
        free(priv->shift);
        free(priv->pair_force);
        free(priv->jump);
        free(priv->jump_force);
        free(priv->column_start);
        free(priv->row);
        free(priv->middle);
        dl_product_free(priv->product);
        dl_jump_pairs_free(priv->crossings);
    }
    free(priv);
    free(model);
}

void dl_model_initial_state(const dl_model *model, double *y) {
    const dl_scene *scene = model->scene;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++) {
            size_t at = c * model->particles + model->priv->order[k], to = c * model->moving + k;
            y[to] = scene->position[at];
            y[model->unknowns + to] = scene->velocity[at];
        }
}

void dl_model_expand(const dl_model *model, const double *y, double *y_all) {
    const dl_scene *scene = model->scene;
    size_t n = model->particles, block = (size_t)model->dimension * n;
    memcpy(y_all, scene->position, block * sizeof *y_all);
    memset(y_all + block, 0, block * sizeof *y_all);
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++) {
            size_t to = c * n + model->priv->order[k], from = c * model->moving + k;
            y_all[to] = y[from];
            y_all[block + to] = y[model->unknowns + from];
        }
}

/* Moving particles into the block of all. */
static const double *with_pinned(const dl_model *model, const double *moving, double *all) {
    if (!all)
        return moving;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        memcpy(all + c * model->particles, moving + c * model->moving, model->moving * sizeof *all);
    return all;
}

const double *dl_model_places(dl_model *model, const double *q) {
    return with_pinned(model, q, model->priv->place);
}

const double *dl_model_shifts(dl_model *model, const double *delta) {
    return with_pinned(model, delta, model->priv->shift);
}

/* Row in the scene of the first particle with a component that is not finite, or `moving`. */
static size_t first_not_finite(const dl_model *model, const double *block) {
    for (size_t k = 0; k < model->moving; k++)
        for (size_t c = 0; c < (size_t)model->dimension; c++)
            if (!isfinite(block[c * model->moving + k]))
                return k;
    return model->moving;
}

static dl_status fail_not_finite(const dl_model *model, const double *q, const double *a,
                                 dl_error *error) {
    size_t k = first_not_finite(model, q);
    if (k < model->moving)
        return dl_fail(error, DL_UNSTABLE, "position of particle %zu is not finite",
                       model->priv->order[k]);
    k = first_not_finite(model, a);
    return dl_fail(error, DL_UNSTABLE,
                   "force on particle %zu is not finite: particles coincide or have blown up",
                   model->priv->order[k < model->moving ? k : 0]);
}

dl_status dl_model_finish(dl_model *model, const double *q, const double *f, double *a,
                          dl_error *error) {
    const struct dl_model_private *priv = model->priv;
    /* a_i = f_i / inertia_i + g */
    bool finite = true;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        double g = model->has_gravity ? model->scene->gravity[c] : 0;
        finite &= priv->vector->finish(f + c * model->particles, priv->inverse_inertia, g,
                                       priv->gravity_mask, a + c * model->moving, model->moving);
    }
    return finite ? DL_OK : fail_not_finite(model, q, a, error);
}

/* Without a pair law only gravity is left. */
static dl_status gravity_alone(dl_model *model, double *a, dl_error *error) {
    memset(a, 0, model->unknowns * sizeof *a);
    if (!model->has_gravity)
        return DL_OK;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++)
            a[c * model->moving + k] =
                model->scene->gravity[c] *
                (model->priv->gravity_mask ? model->priv->gravity_mask[k] : 1);
    (void)error;
    return DL_OK;
}

/* What rests on a wall is out of the dynamics. */
static void hold(const dl_model *model, double *a) {
    for (size_t u = 0; u < model->unknowns; u++)
        if (model->held[u])
            a[u] = 0;
}

dl_status dl_model_accelerate(dl_model *model, const double *q, double *a, dl_error *error) {
    if (!model->kernel)
        return gravity_alone(model, a, error);
    double *f = model->has_pins ? model->priv->pair_force : a;
    dl_status status =
        model->kernel->ops->force(model->kernel, dl_model_places(model, q), f, error);
    if (status == DL_OK)
        status = dl_model_finish(model, q, f, a, error);
    if (status == DL_OK && model->locks)
        dl_locks_add_acceleration(model, q, a);
    return status;
}

dl_status dl_model_accelerate_quotient(dl_model *model, const double *q, const double *delta,
                                       double *a, dl_error *error) {
    if (!model->kernel)
        return gravity_alone(model, a, error);
    double *f = model->has_pins ? model->priv->pair_force : a;
    dl_status status = model->kernel->ops->discrete(model->kernel, dl_model_places(model, q),
                                                    dl_model_shifts(model, delta), f, error);
    if (status == DL_OK)
        status = dl_model_finish(model, q, f, a, error);
    if (status == DL_OK && model->locks)
        dl_locks_add_discrete(model, q, delta, a);
    return status;
}

dl_status dl_model_acceleration(dl_model *model, const double *q, double *a, dl_error *error) {
    model->counts.force++;
    const dl_status status = model->acceleration(model, q, a, error);
    if (model->held)
        hold(model, a);
    return status;
}

dl_status dl_model_part_acceleration(dl_model *model, dl_part part, const double *q, double *a,
                                     dl_error *error) {
    model->counts.force++;
    const dl_status status = model->part_acceleration(model, part, q, a, error);
    if (model->held)
        hold(model, a);
    return status;
}

dl_status dl_model_rhs(dl_model *model, const double *y, double *ydot, dl_error *error) {
    memcpy(ydot, y + model->unknowns, model->unknowns * sizeof *ydot);
    return dl_model_acceleration(model, y, ydot + model->unknowns, error);
}

dl_status dl_model_discrete_acceleration(dl_model *model, const double *q, const double *delta,
                                         double *a, dl_error *error) {
    model->counts.force += model->mean == DL_MEAN_GONZALEZ ? 2 : 1;
    const dl_status status = model->discrete_acceleration(model, q, delta, a, error);
    if (model->held)
        hold(model, a);
    return status;
}

unsigned long dl_model_list_builds(const dl_model *model) {
    unsigned long builds = model->kernel ? model->kernel->list_builds : 0;
    for (int which = DL_PART_FAST; which <= DL_PART_SLOW; which++)
        builds += model->priv->part[which] ? dl_model_list_builds(model->priv->part[which]) : 0;
    return builds;
}
