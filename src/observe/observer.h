/* What is measured on a run: energies, momenta, and the ledger of what walls and radiation take.
 *
 *     error of the integrator = E(t) + ledger - E(0)
 *     ledger = sum over jumps of E(before) - E(after)
 *
 * Both states of a jump are the method's own at that time (dl_method_state), so that the ledger is
 * exact for every method and the error holds nothing but the integrator's. The same holds for the
 * momenta: the walls' impulses are booked at the jumps, and gravity's impulse is known.
 *
 * The observer evaluates energies and forces on a model of its own, with its own counts and
 * neighbour list: what is observed cannot change what is integrated, by a single bit. */
#ifndef DL_OBSERVE_OBSERVER_H
#define DL_OBSERVE_OBSERVER_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/method.h"
#include "driftlab/run.h"

typedef struct dl_observer dl_observer;

/* Without a ledger jumps are not booked, which saves a change of energy each: after the first one
 * there are no errors, NaN. */
dl_status dl_observer_create(const dl_scene *scene, bool ledger, dl_observer **observer,
                             dl_error *error);
void dl_observer_free(dl_observer *observer);

/* Takes the method's present state as the start, with which everything later is compared; sets the
 * scales of the summary. DL_UNSTABLE where its energy is not finite. The first sample is of that
 * state, which is not measured again. */
dl_status dl_observer_begin(dl_observer *observer, dl_method *method, dl_run_summary *summary,
                            dl_error *error);

/* Sets every field of `sample` but index. sample->y_all belongs to the observer and holds until the
 * next call. Values that are not finite are passed on as they are. */
dl_status dl_observer_sample(dl_observer *observer, dl_method *method, double time,
                             dl_sample *sample, dl_error *error);

/* Around whatever changes the method's state from outside: the difference is booked. */
dl_status dl_observer_before_jump(dl_observer *observer, dl_method *method, dl_error *error);
dl_status dl_observer_after_jump(dl_observer *observer, dl_method *method, dl_error *error);

/* A particle has come to rest on a wall. What holds it does no work, so that the ledger stays
 * exact, but its impulse is not known: momentum errors are NaN from now on. */
void dl_observer_contact(dl_observer *observer);

/* E(0), the value that energy_error is measured from. */
double dl_observer_initial_energy(const dl_observer *observer);

#endif
