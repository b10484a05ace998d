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

/* Computes the reference of a scene in extended precision, or runs it and its check, or solves it
 * exactly. DL_INTERRUPTED; any other failure is the reference's own and is told in the message. */
dl_status dl_study_measure_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference,
                                     dl_error *error);

/* Puts a reference in quad precision in the place of one in long double. Where that is out of reach
 * its note says why, and nothing else changes: DL_OK all the same. */
dl_status dl_study_improve_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference, bool *improved,
                                     dl_error *error);

/* Runs one case. A case that fails is measured: DL_OK. DL_INTERRUPTED, or DL_MEMORY and DL_IO of
 * the study itself. reference: NULL where there is none. */
dl_status dl_study_measure_case(const dl_study *study, const dl_study_case *cased,
                                const dl_reference *reference, const dl_watch *watch,
                                dl_case *measured, dl_error *error);

/* Why a run that has not failed is not what it claims, or "". `end`: where the runs on that scene
 * end. */
void dl_study_judge_run(const dl_case *measured, double end, long intervals, char *reason,
                        size_t size);
/* Why its position error is not to be trusted, or "". */
void dl_study_judge_position(const dl_case *measured, const dl_reference *reference, char *reason,
                             size_t size);

#endif
