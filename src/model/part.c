/* The fast and the slow part of a scene's force, each as a model of its own: the same particles
 * under the terms of one part. What ends a piece of a law (a jump, a shift, a taper) is linear in
 * its terms, so that the parts' forces add up to the whole. */
#include "model/private.h"

dl_pair_law dl_pair_law_part(const dl_pair_law *law, dl_part part) {
    dl_pair_law own = *law;
    own.pieces = 0;
    for (int k = 0; k < law->pieces; k++) {
        const dl_piece *const from = &law->piece[k];
        dl_piece *const to = &own.piece[k];
        to->terms = 0;
        for (int s = 0; s < from->terms; s++)
            if (from->part[s] == part && from->term[s].coefficient != 0)
                to->term[to->terms++] = from->term[s];
        if (to->terms > 0)
            own.pieces = k + 1;
    }
    return own;
}

static bool is_empty(const dl_model *part) {
    return part->priv->problem.reach == 0 && !part->has_gravity;
}

dl_status dl_model_split(dl_model *model, dl_error *error) {
    dl_model **const part = model->priv->part;
    if (part[DL_PART_FAST])
        return DL_OK;
    dl_status status = DL_OK;
    if (model->locates_crossings)
        status = dl_fail(error, DL_INPUT,
                         "%s: found a pair law whose crossings are located, expected none where "
                         "the force is split",
                         model->scene->file);
    for (int which = DL_PART_FAST; which <= DL_PART_SLOW && !status; which++)
        status = dl_model_create_part(model->scene, model, (dl_part)which, &part[which], error);
    if (!status && is_empty(part[DL_PART_FAST]))
        status = dl_fail(error, DL_INPUT,
                         "%s: no force is fast, expected a term of the pair law with part: fast",
                         model->scene->file);
    if (!status && is_empty(part[DL_PART_SLOW]))
        status = dl_fail(error, DL_INPUT,
                         "%s: no force is slow, expected gravity, or a term of the pair law with "
                         "part: slow",
                         model->scene->file);
    if (status)
        dl_model_free_parts(model);
    return status;
}

void dl_model_free_parts(dl_model *model) {
    for (int which = DL_PART_FAST; which <= DL_PART_SLOW; which++) {
        dl_model_free(model->priv->part[which]);
        model->priv->part[which] = NULL;
    }
}

dl_model *dl_model_part(dl_model *model, dl_part part) {
    dl_model *const its = model->priv->part[part];
    its->held = model->held;
    return its;
}

dl_status dl_model_accelerate_part(dl_model *model, dl_part part, const double *q, double *a,
                                   dl_error *error) {
    return dl_model_accelerate(model->priv->part[part], q, a, error);
}
