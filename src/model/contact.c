#include "model/contact.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

double dl_wall_place(const dl_model *model, size_t u, dl_side side) {
    const dl_walls *walls = &model->scene->walls;
    const size_t axis = u / model->moving;
    return side == DL_LOW_WALL ? walls->low[axis] : walls->high[axis];
}

dl_status dl_contacts_create(dl_contacts *contacts, dl_model *model, dl_error *error) {
    *contacts = (dl_contacts){.model = model};
    contacts->side = calloc(model->unknowns, sizeof *contacts->side);
    contacts->held = calloc(model->unknowns, sizeof *contacts->held);
    contacts->pressed = calloc(model->unknowns, sizeof *contacts->pressed);
    contacts->idle = calloc(model->unknowns, sizeof *contacts->idle);
    contacts->slides = calloc(model->unknowns, sizeof *contacts->slides);
    return contacts->side && contacts->held && contacts->pressed && contacts->idle &&
                   contacts->slides
               ? DL_OK
               : dl_fail_memory(error, "resting contacts");
}

void dl_contacts_free(dl_contacts *contacts) {
    if (contacts->model)
        contacts->model->held = NULL;
    free(contacts->side);
    free(contacts->held);
    free(contacts->pressed);
    free(contacts->idle);
    free(contacts->slides);
    *contacts = (dl_contacts){.model = NULL};
}

/* Holds what particle k's contacts hold, and nothing else of it. */
static void update_particle(dl_contacts *contacts, size_t k) {
    const dl_model *model = contacts->model;
    const size_t n = model->moving;
    const bool sticks = model->scene->walls.damping > 0;
    bool rests = false;
    for (size_t u = k; u < model->unknowns; u += n)
        rests |= sticks && contacts->side[u] != DL_NO_WALL && !contacts->slides[u];
    for (size_t u = k; u < model->unknowns; u += n)
        contacts->held[u] = rests || contacts->side[u] != DL_NO_WALL;
}

static void set_side(dl_contacts *contacts, size_t u, dl_side side) {
    dl_model *model = contacts->model;
    contacts->count += side != DL_NO_WALL;
    contacts->count -= contacts->side[u] != DL_NO_WALL;
    contacts->side[u] = (signed char)side;
    update_particle(contacts, u % model->moving);
    model->held = contacts->count ? contacts->held : NULL;
}

void dl_contacts_add(dl_contacts *contacts, size_t u, dl_side side, bool pressed, double *v) {
    const size_t n = contacts->model->moving, k = u % n;
    contacts->pressed[u] = pressed;
    contacts->idle[u] = contacts->slides[u] = false;
    set_side(contacts, u, side);
    for (size_t c = 0; c < (size_t)contacts->model->dimension; c++)
        if (contacts->held[c * n + k])
            v[c * n + k] = 0;
}

void dl_contacts_release(dl_contacts *contacts, size_t u) {
    set_side(contacts, u, DL_NO_WALL);
}

void dl_contacts_let_slide(dl_contacts *contacts, size_t u) {
    contacts->slides[u] = true;
    contacts->idle[u] = false;
    update_particle(contacts, u % contacts->model->moving);
}

bool dl_contacts_hold(const dl_contacts *contacts, size_t u) {
    return contacts->held[u];
}

void dl_contacts_last(dl_contacts *contacts) {
    for (size_t u = 0; contacts->count && u < contacts->model->unknowns; u++)
        contacts->pressed[u] |= contacts->side[u] != DL_NO_WALL;
}

/* d a/d t along y of all particles as if none were held. */
static dl_status acceleration_rate(const dl_contacts *contacts, const double *y, double *rate,
                                   dl_error *error) {
    dl_model *model = contacts->model;
    const bool *held = model->held;
    model->held = NULL;
    const dl_status status = dl_model_jacobian_vector(model, y, y + model->unknowns, rate, error);
    model->held = held;
    return status;
}

dl_status dl_contacts_find_idle(dl_contacts *contacts, const double *y, const double *a,
                                double *rate, dl_error *error) {
    bool any = false;
    for (size_t u = 0; contacts->count && u < contacts->model->unknowns; u++) {
        contacts->idle[u] = contacts->side[u] != DL_NO_WALL && contacts->pressed[u] &&
                            !contacts->slides[u] && a[u] == 0;
        any |= contacts->idle[u];
    }
    const dl_status status = any ? acceleration_rate(contacts, y, rate, error) : DL_OK;
    for (size_t u = 0; any && !status && u < contacts->model->unknowns; u++)
        contacts->idle[u] &= rate[u] == 0;
    return status;
}

double dl_contacts_press(const dl_contacts *contacts, size_t u, const double *a) {
    const double press = -dl_wall_away((dl_side)contacts->side[u], a[u]);
    return press == 0 && contacts->idle[u] ? -DBL_MIN : press;
}

double dl_contacts_least_press(const dl_contacts *contacts, const double *a) {
    double least = INFINITY;
    for (size_t u = 0; contacts->count && u < contacts->model->unknowns; u++)
        if (contacts->side[u] != DL_NO_WALL)
            least = fmin(least, dl_contacts_press(contacts, u, a));
    return least;
}

dl_status dl_contacts_acceleration(const dl_contacts *contacts, const double *q, double *a,
                                   dl_error *error) {
    dl_model *model = contacts->model;
    const bool *held = model->held;
    model->held = NULL;
    const dl_status status = dl_model_acceleration(model, q, a, error);
    model->held = held;
    return status;
}
