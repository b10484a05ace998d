#include "reference/extended/law.h"

#include <string.h>

static real sum_of(const law_sum *sum, real r) {
    const real inverse = 1 / r;
    real value = 0;
    for (int k = 0; k < sum->terms; k++)
        value += law_term_over_r(&sum->term[k], r, inverse);
    return value;
}

static void add_term(law_sum *sum, real coefficient, double power) {
    const bool is_whole = power == floor(power);
    sum->term[sum->terms++] =
        (law_term){.coefficient = coefficient, .power = power, .whole = is_whole ? (int)power : -1};
}

static law_sum sum_with_shift(const dl_piece *source, real shift) {
    law_sum sum = {.terms = 0};
    for (int k = 0; k < source->terms; k++)
        add_term(&sum, source->term[k].coefficient, source->term[k].power);
    if (shift != 0)
        add_term(&sum, shift, 0);
    return sum;
}

/* From the last inwards: a piece is shifted to meet the next as that one has become. */
static void find_shifts(const dl_pair_law *source, real *shift) {
    for (int k = source->pieces - 1; k >= 0; k--) {
        const dl_piece *piece = &source->piece[k];
        shift[k] = 0;
        if (piece->end != DL_END_SHIFTED_FORCE)
            continue;
        const real r = piece->until;
        const law_sum own = sum_with_shift(piece, 0);
        real next = 0;
        if (k + 1 < source->pieces) {
            const law_sum behind = sum_with_shift(piece + 1, shift[k + 1]);
            next = sum_of(&behind, r) * r;
        }
        shift[k] = next - sum_of(&own, r) * r;
    }
}

static void add_taper(const dl_pair_law *source, int k, const real *shift, law *made) {
    const dl_piece *piece = &source->piece[k];
    law_piece *taper = &made->piece[made->pieces++];
    *taper = (law_piece){.begin = (real)piece->until - piece->width,
                         .until = piece->until,
                         .ends = true,
                         .tapers = true,
                         .width = piece->width,
                         .own = sum_with_shift(piece, 0)};
    if (k + 1 < source->pieces)
        taper->next = sum_with_shift(piece + 1, shift[k + 1]);
}

void law_prepare(const dl_pair_law *source, law *made) {
    real shift[DL_MAX_PIECES], begin = 0;
    memset(made, 0, sizeof *made);
    find_shifts(source, shift);
    for (int k = 0; k < source->pieces; k++) {
        const dl_piece *piece = &source->piece[k];
        const bool tapers = piece->end == DL_END_TAPER, ends = isfinite(piece->until);
        made->piece[made->pieces++] =
            (law_piece){.begin = begin,
                        .until = tapers ? (real)piece->until - piece->width : piece->until,
                        .ends = ends,
                        .own = sum_with_shift(piece, shift[k])};
        if (tapers)
            add_taper(source, k, shift, made);
        begin = piece->until;
    }
}

int law_piece_at(const law *of, real r) {
    int k = 0;
    while (k < of->pieces && r > of->piece[k].until)
        k++;
    return k;
}

static real whole_power(real x, int n) {
    real result = n & 1 ? x : 1;
    for (n >>= 1; n > 0; n >>= 1) {
        x *= x;
        if (n & 1)
            result *= x;
    }
    return result;
}

real law_term_over_r(const law_term *term, real r, real inverse) {
    const real power =
        term->whole >= 0 ? whole_power(inverse, term->whole + 1) : real_pow(r, -term->power - 1);
    return term->coefficient * power;
}

real law_force_over_r(const law_piece *piece, real r_squared) {
    const real r = real_sqrt(r_squared), own = sum_of(&piece->own, r);
    if (!piece->tapers)
        return own;
    const real v = (piece->until - r) / piece->width;
    const real fade = v * v * v * (10 + v * (6 * v - 15)), next = sum_of(&piece->next, r);
    return next + fade * (own - next);
}
