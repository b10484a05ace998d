/* What a study measures: references, and cases against them. */
#ifndef DL_STUDY_MEASURE_H
#define DL_STUDY_MEASURE_H

#include "study/plan.h"

/* Parent-side hooks while a child works. */
typedef struct dl_watch {
    const volatile int *interrupt;
    void (*tick)(void *context);
    void *context;
} dl_watch;

/* Runs the reference of a scene and its check, or computes the exact one. DL_INTERRUPTED; any other
 * failure is the reference's own and is told in the message. */
dl_status dl_study_measure_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference,
                                     dl_error *error);

/* Runs one case. A case that fails is measured: DL_OK. DL_INTERRUPTED, or DL_MEMORY and DL_IO of
 * the study itself. reference: NULL where there is none. */
dl_status dl_study_measure_case(const dl_study *study, const dl_study_case *cased,
                                const dl_reference *reference, const dl_watch *watch,
                                dl_case *measured, dl_error *error);

/* RMS over the particles that move of the distance between two sets of positions [dimension *
 * particles]; *largest (may be NULL) is the largest distance. */
double dl_position_distance(const dl_scene *scene, const double *a, const double *b,
                            double *largest);

/* Why a run that has not failed is not what it claims, or "". `end`: where the runs on that scene
 * end. */
void dl_study_judge_run(const dl_case *measured, double end, long intervals, char *reason,
                        size_t size);
/* Why its position error is not to be trusted, or "". */
void dl_study_judge_position(const dl_case *measured, const dl_reference *reference, char *reason,
                             size_t size);

#endif
