/* One step of a splitting: kicks and drifts by turns, exact flows of the two parts of q'' = a(q).
 *
 * Kicks and drifts conserve both momenta and are symplectic, and so is every step made of them. The
 * force of a kick that ends a step is that of the kick that begins the next. Where nothing acts
 * there is no kick between the drifts and they are one; where gravity alone does there is nothing
 * to evaluate. */
#include <stdlib.h>
#include <string.h>

#include "methods/compensated.h"
#include "methods/motion.h"
#include "methods/options.h"
#include "methods/registry.h"
#include "methods/splitting.h"

const dl_parameter dl_splitting_parameters[2] = {
    DL_OPTION_FIXED_STEP(dl_splitting_options),
    {
        .name = "compensated",
        .kind = DL_FLAG,
        .offset = offsetof(dl_splitting_options, compensated),
        .unit = "",
        .fallback = "false",
        .doc = "keep what the sums for positions and velocities round off, and add it later; a "
               "restart then agrees to roundoff only",
    },
};

typedef struct composition {
    dl_splitting splitting;
    double *a;            /* [unknowns]; NULL: there is nothing to evaluate, and nothing fails */
    double *work;         /* [2 unknowns]: the state between stages; a failure leaves y alone */
    double *lost;         /* [2 unknowns]: what y has rounded off; NULL: not kept */
    double *lost_between; /* [2 unknowns]: the same between stages */
    bool a_is_current;    /* a is the acceleration at y */
    unsigned long steps;
} composition;

/* --- tables ------------------------------------------------------------------------------------
 */

static double coefficient(const dl_splitting_table *table, int index) {
    const int mirrored = table->count - 1 - index;
    return table->coefficient[table->symmetric && mirrored < index ? mirrored : index];
}

/* The kicks of neighbouring Verlet steps act at one position and are one. */
static void expand_verlet(const dl_splitting_table *table, dl_splitting *splitting) {
    splitting->drifts = table->count;
    double before = 0;
    for (int i = 0; i < table->count; i++) {
        const double weight = coefficient(table, i);
        splitting->kick[i] = (before + weight) / 2;
        splitting->drift[i] = weight;
        before = weight;
    }
    splitting->kick[table->count] = before / 2;
}

void dl_splitting_expand(const dl_splitting_table *table, dl_splitting *splitting) {
    *splitting = (dl_splitting){0};
    if (table->form == DL_OF_VERLET) {
        expand_verlet(table, splitting);
        return;
    }
    const int first = table->form == DL_FROM_DRIFT; /* its kick[0] is 0 */
    splitting->drifts = (table->count + first) / 2;
    for (int i = 0; i < table->count; i++) {
        const int place = i + first;
        double *const part = place % 2 ? splitting->drift : splitting->kick;
        part[place / 2] = coefficient(table, i);
    }
}

/* --- a step ------------------------------------------------------------------------------------
 */

static void compensated_kick_and_drift(size_t n, double kick, double drift, const double *a,
                                       double *y, double *lost) {
    for (size_t i = 0; i < n; i++) {
        if (kick != 0)
            dl_compensated_add(&y[n + i], &lost[n + i], kick * a[i]);
        dl_compensated_add(&y[i], &lost[i], drift * y[n + i]);
    }
}

/* The first stage of a step, from y into the work. */
static void begin(const composition *data, const double *y, size_t n, double kick, double drift) {
    if (data->lost) {
        memcpy(data->work, y, 2 * n * sizeof *y);
        memcpy(data->lost_between, data->lost, 2 * n * sizeof *y);
        compensated_kick_and_drift(n, kick, drift, data->a, data->work, data->lost_between);
    } else if (kick == 0)
        dl_drift_from(n, drift, y, data->work);
    else
        dl_kick_and_drift_from(n, kick, drift, data->a, y, data->work);
}

static void move(const composition *data, size_t n, double kick, double drift) {
    if (data->lost)
        compensated_kick_and_drift(n, kick, drift, data->a, data->work, data->lost_between);
    else if (drift == 0)
        dl_kick(n, kick, data->a, data->work + n);
    else
        dl_kick_and_drift(n, kick, drift, data->a, data->work, data->work + n);
}

static void exchange(double **a, double **b) {
    double *const between = *a;
    *a = *b;
    *b = between;
}

static void advance_straight(dl_method *method) {
    const composition *const data = method->data;
    const size_t n = method->n;
    double *const y = method->y;
    if (!data->lost)
        dl_drift(n, method->step, y, y + n);
    for (size_t i = 0; data->lost && i < n; i++)
        dl_compensated_add(&y[i], &data->lost[i], method->step * y[n + i]);
}

static void advance_falling(dl_method *method) {
    const dl_splitting *const splitting = &((const composition *)method->data)->splitting;
    const double h = method->step;
    for (int i = 0; i <= splitting->drifts; i++)
        dl_fall(method->model, splitting->kick[i] * h,
                i < splitting->drifts ? splitting->drift[i] * h : 0, method->y,
                method->y + method->n);
}

static dl_status advance_by_stages(dl_method *method, dl_error *error) {
    composition *const data = method->data;
    const dl_splitting *const splitting = &data->splitting;
    const int last = splitting->drifts;
    const size_t n = method->n;
    const double h = method->step;
    const double *from = method->y;
    bool known = data->a_is_current || splitting->kick[0] == 0;
    data->a_is_current = false;
    for (int i = 0; i < last; i++, from = data->work, known = false) {
        const double kick = splitting->kick[i] * h, drift = splitting->drift[i] * h;
        const dl_status status =
            known ? DL_OK : dl_model_acceleration(method->model, from, data->a, error);
        if (status)
            return status;
        if (i == 0)
            begin(data, from, n, kick, drift);
        else
            move(data, n, kick, drift);
    }
    if (splitting->kick[last] != 0) {
        const dl_status status = dl_model_acceleration(method->model, data->work, data->a, error);
        if (status)
            return status;
        move(data, n, splitting->kick[last] * h, 0);
        data->a_is_current = true;
    }
    exchange(&method->y, &data->work);
    if (data->lost)
        exchange(&data->lost, &data->lost_between);
    return DL_OK;
}

static dl_status composition_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    composition *const data = method->data;
    if (data->a) {
        const dl_status status = advance_by_stages(method, error);
        if (status)
            return status;
    } else if (method->model->is_uniform)
        advance_falling(method);
    else
        advance_straight(method);
    data->steps++;
    dl_method_count_step(method);
    return DL_OK;
}

/* --- life --------------------------------------------------------------------------------------
 */

static dl_status composition_create(dl_method *method, dl_error *error) {
    const dl_splitting_options *const options = method->options;
    const size_t n = method->n;
    method->step = options->step;
    composition *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "a composition method");
    dl_splitting_expand(method->row->variant, &data->splitting);
    if (options->compensated && !(data->lost = calloc(2 * n, sizeof *data->lost)))
        return dl_fail_memory(error, "what a composition rounds off");
    if (!method->model->has_force || (method->model->is_uniform && !options->compensated))
        return DL_OK;
    data->a = malloc(n * sizeof *data->a);
    data->work = malloc(2 * n * sizeof *data->work);
    if (options->compensated)
        data->lost_between = malloc(2 * n * sizeof *data->lost_between);
    return data->a && data->work && (!options->compensated || data->lost_between)
               ? DL_OK
               : dl_fail_memory(error, "a composition's stages");
}

static dl_status composition_jumped(dl_method *method, dl_error *error) {
    (void)error;
    composition *const data = method->data;
    data->a_is_current = false;
    if (data->lost)
        memset(data->lost, 0, 2 * method->n * sizeof *data->lost);
    return DL_OK;
}

static void composition_stats(const dl_method *method, dl_method_stats *stats) {
    stats->steps = ((const composition *)method->data)->steps;
}

static void composition_destroy(dl_method *method) {
    composition *const data = method->data;
    if (!data)
        return;
    free(data->a);
    free(data->work);
    free(data->lost);
    free(data->lost_between);
    free(data);
}

const dl_method_ops dl_splitting_ops = {
    .create = composition_create,
    .advance = composition_advance,
    .jumped = composition_jumped,
    .stats = composition_stats,
    .destroy = composition_destroy,
};
