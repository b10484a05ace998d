/* When rest ends: the net normal force turns away from the wall, or is no more. */
#include <string.h>

#include "study/located_parts.h"

static dl_status press_at(dl_located *located, double t, double *press, dl_error *error) {
    dl_status status = dl_located_state_at(located, t, error);
    if (!status)
        status =
            dl_contacts_acceleration(&located->contacts, located->method->y, located->a1, error);
    if (!status)
        *press = dl_contacts_least_press(&located->contacts, located->a1);
    return status;
}

/* A bracket of the time at which the press turns negative. */
typedef struct bracket {
    double low, high, at_low, at_high;
} bracket;

/* The next time to look at, by ITP (I. F. D. Oliveira, R. H. C. Takahashi, ACM Trans. Math. Softw.
 * 47 (2020) 5, doi:10.1145/3423597): as fast as the secant method where the force is smooth, never
 * more than a step slower than bisection where it jumps. */
static double itp_point(const bracket *b, double width, double tolerance, int taken, int allowed) {
    const double middle = b->low + (b->high - b->low) / 2;
    const double secant = b->low + (b->high - b->low) * b->at_low / (b->at_low - b->at_high);
    const double slack = 0.2 * (b->high - b->low) * (b->high - b->low) / width;
    const double towards = middle >= secant ? 1 : -1;
    const double shifted = slack <= fabs(middle - secant) ? secant + towards * slack : middle;
    const double radius = ldexp(tolerance, allowed - taken) - (b->high - b->low) / 2;
    return fabs(shifted - middle) <= radius ? shifted : middle - towards * radius;
}

/* Goes to the first time found, at or before `end`, where a contact presses no more; at_start and
 * at_end are the least press at t0 and there. */
static dl_status go_to_release(dl_located *located, double at_start, double end, double at_end,
                               dl_error *error) {
    const double width = end - located->t0;
    const double tolerance = fmax(dl_located_resolution(end) / 4, width * DBL_EPSILON);
    bracket b = {located->t0, end, at_start, at_end};
    const int allowed = 1 + (int)fmax(0, ceil(log2(width / (2 * tolerance))));
    double press = NAN, reached = NAN;
    for (int taken = 0; taken < 200 && b.high - b.low > 2 * tolerance; taken++) {
        const double t = itp_point(&b, width, tolerance, taken, allowed);
        if (!(t > b.low && t < b.high))
            break;
        const dl_status status = press_at(located, t, &press, error);
        if (status)
            return status;
        reached = t;
        b = press < 0 ? (bracket){b.low, t, b.at_low, press}
                      : (bracket){t, b.high, press, b.at_high};
    }
    return reached == b.high ? DL_OK : press_at(located, b.high, &press, error);
}

dl_status dl_located_release(dl_located *located, dl_error *error) {
    dl_contacts *const contacts = &located->contacts;
    for (size_t u = 0; u < located->model->unknowns; u++)
        if (contacts->side[u] != DL_NO_WALL && dl_contacts_press(contacts, u, located->a1) < 0) {
            located->counts.releases += !contacts->slides[u];
            if (located->a1[u] == 0)
                dl_contacts_let_slide(contacts, u);
            else
                dl_contacts_release(contacts, u);
        }
    memcpy(located->a0, located->a1, located->model->unknowns * sizeof *located->a0);
    located->a0_is_current = true;
    return dl_method_jumped(located->method, error);
}

/* The press of a contact at three times, -h_before, 0 and h: where in (0, h) the parabola through
 * them has its least value, if that is much less than at either end; INFINITY otherwise. */
static double dip_of(double before, double start, double end, double h_before, double h) {
    const double first = (start - before) / h_before, second = (end - start) / h;
    const double curvature = 2 * (second - first) / (h + h_before);
    const double rate = second - curvature * h / 2; /* at 0 */
    const double at = -rate / curvature;
    if (!(curvature > 0 && at > 0 && at < h))
        return INFINITY;
    return start - curvature * at * at / 2 < fmin(start, end) / 2 ? at : INFINITY;
}

/* The least press at a time within the step, by the interpolant that hits are found with. */
static dl_status peek(dl_located *located, double t, double *press, dl_error *error) {
    dl_method *const method = located->method;
    const double h = method->t - located->t0, s = (t - located->t0) / h;
    dl_status status = DL_OK;
    if (method->row->ops->dense)
        status = method->row->ops->dense(method, t, 0, located->scratch, error);
    for (size_t u = 0; u < method->n && !method->row->ops->dense; u++) {
        const double *const y0 = located->y0, *const y1 = method->y;
        const bool held = dl_contacts_hold(&located->contacts, u);
        dl_path path;
        dl_path_hermite(&path, h, (dl_path_end){y0[u], y0[method->n + u], located->a0[u]},
                        (dl_path_end){y1[u], y1[method->n + u], located->a1[u]});
        located->scratch[u] = held ? y0[u] : dl_path_value(&path, s);
    }
    double *const a = located->scratch + method->n;
    if (!status)
        status = dl_contacts_acceleration(&located->contacts, located->scratch, a, error);
    if (!status)
        *press = dl_contacts_least_press(&located->contacts, a);
    return status;
}

/* A force that turns away from the wall and back within the step shows in the steps' ends as a dip:
 * there it is looked at. *at_dip is the press there, as it was where there is none. */
static dl_status look_between(dl_located *located, double end, double *dip, double *at_dip,
                              dl_error *error) {
    const dl_contacts *const contacts = &located->contacts;
    const double h = end - located->t0;
    double first = INFINITY;
    if (!(located->h_before > 0 && h > 0))
        return DL_OK;
    for (size_t u = 0; u < located->model->unknowns; u++)
        if (contacts->side[u] != DL_NO_WALL)
            first = fmin(first,
                         dip_of(dl_contacts_press(contacts, u, located->a_before),
                                dl_contacts_press(contacts, u, located->a0),
                                dl_contacts_press(contacts, u, located->a1), located->h_before, h));
    if (!(first < h) || end < located->method->t)
        return DL_OK;
    *dip = located->t0 + first;
    return peek(located, *dip, at_dip, error);
}

dl_status dl_located_find_release(dl_located *located, double end, bool *released,
                                  dl_error *error) {
    *released = false;
    if (located->contacts.count == 0)
        return DL_OK;
    const dl_status found = dl_contacts_find_idle(&located->contacts, located->method->y,
                                                  located->a1, located->scratch, error);
    if (found)
        return found;
    double press, dip = end, at_end = dl_contacts_least_press(&located->contacts, located->a1);
    const double at_start = dl_contacts_least_press(&located->contacts, located->a0);
    if (at_start < 0) {
        *released = true;
        return press_at(located, located->t0, &press, error);
    }
    if (at_end >= 0) {
        const dl_status status = look_between(located, end, &dip, &at_end, error);
        if (status || at_end >= 0)
            return status;
    }
    *released = true;
    return go_to_release(located, at_start, dip, at_end, error);
}
