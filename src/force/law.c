#include "force/law.h"

#include <math.h>
#include <string.h>
#include "force/law_taper.h"
#include "force/whole_power.h"

/* --- preparation ------------------------------------------------------------------------------ */

static void sort_terms(dl_piece *piece) {
    for (int i = 1; i < piece->terms; i++)
        for (int j = i; j > 0 && piece->term[j].power < piece->term[j - 1].power; j--) {
            dl_term swap = piece->term[j];
            piece->term[j] = piece->term[j - 1];
            piece->term[j - 1] = swap;
        }
}

static void add_term(dl_law *law, int k, int *terms, double coefficient, double power) {
    int s = law->terms[k] + law->next_terms[k];
    law->coefficient[k][s] = coefficient;
    law->power[k][s] = power;
    if (power == floor(power) && (power == 0 || (power >= 2 && power <= 64)))
        law->whole_power[k][s] = (int)power;
    else
        law->integer = false;
    ++*terms;
}

/* The sum that a piece of the scene is, its shift included. */
static void add_sum(dl_law *law, int k, int *terms, const dl_piece *source, double shift) {
    dl_piece piece = *source;
    sort_terms(&piece);
    if (shift != 0)
        add_term(law, k, terms, shift, 0);
    for (int s = 0; s < piece.terms; s++)
        add_term(law, k, terms, piece.term[s].coefficient, piece.term[s].power);
}

static void end_piece(dl_law *law, double until) {
    law->until[law->pieces] = until;
    law->until2[law->pieces] = until * until;
    law->pieces++;
}

static double force_of(const dl_piece *piece, double r) {
    double sum = 0;
    for (int s = 0; s < piece->terms; s++)
        sum += piece->term[s].coefficient * pow(r, -piece->term[s].power);
    return sum;
}

/* What is added to the force of each piece: from the last inwards, for a piece is shifted to meet
 * the next as that one has become. */
static void find_shifts(const dl_pair_law *source, double *shift) {
    for (int k = source->pieces - 1; k >= 0; k--) {
        const dl_piece *piece = &source->piece[k];
        shift[k] = 0;
        if (piece->end != DL_END_SHIFTED_FORCE)
            continue;
        double r = piece->until;
        double next = k + 1 < source->pieces ? force_of(piece + 1, r) + shift[k + 1] : 0;
        shift[k] = next - force_of(piece, r);
    }
}

static void add_blend(const dl_pair_law *source, int from, const double *shift, dl_law *law) {
    const dl_piece *piece = &source->piece[from];
    int k = law->pieces;
    law->end[k] = DL_END_TAPER;
    law->width[k] = piece->width;
    add_sum(law, k, &law->terms[k], piece, 0);
    if (from + 1 < source->pieces)
        add_sum(law, k, &law->next_terms[k], piece + 1, shift[from + 1]);
    double largest = 0;
    for (int s = 0; s < law->terms[k] + law->next_terms[k]; s++)
        largest = fmax(largest, law->power[k][s]);
    law->panel[k] = dl_taper_panel(largest);
    end_piece(law, piece->until);
}

static double potential_in(const dl_law *law, int piece, double r);

static void find_constants(dl_law *law) {
    double v = 0; /* V at the end of piece k */
    for (int k = law->pieces - 1; k >= 0; k--) {
        law->constant[k] = v;
        if (law->width[k] == 0 && isfinite(law->until[k])) {
            law->constant[k] = 0;
            law->constant[k] = v - potential_in(law, k, law->until[k]);
        }
        if (k > 0)
            v = potential_in(law, k, law->until[k - 1]);
    }
}

void dl_law_prepare(const dl_pair_law *source, dl_law *law) {
    double shift[DL_MAX_PIECES];
    memset(law, 0, sizeof *law);
    law->integer = true;
    find_shifts(source, shift);
    for (int from = 0; from < source->pieces; from++) {
        const dl_piece *piece = &source->piece[from];
        bool tapers = piece->end == DL_END_TAPER;
        law->end[law->pieces] = piece->end;
        law->located[law->pieces] = piece->located;
        add_sum(law, law->pieces, &law->terms[law->pieces], piece, shift[from]);
        end_piece(law, tapers ? piece->until - piece->width : piece->until);
        if (tapers)
            add_blend(source, from, shift, law);
    }
    law->cut = law->pieces > 0 && isfinite(law->until[law->pieces - 1]);
    find_constants(law);
}

/* --- force and potential ---------------------------------------------------------------------- */

int dl_law_piece(const dl_law *law, double r_squared) {
    int k = 0;
    while (k < law->pieces && r_squared > law->until2[k])
        k++;
    return k;
}

/* r^(-p - more) of term s. */
static double power_of(const dl_law *law, int piece, int s, double r, int more) {
    return law->integer ? dl_whole_power(1 / r, law->whole_power[piece][s] + more)
                        : pow(r, -law->power[piece][s] - more);
}

double dl_law_sum(const dl_law *law, int piece, int first, int terms, double r, int more) {
    double sum = 0;
    for (int s = first; s < first + terms; s++)
        sum += law->coefficient[piece][s] * power_of(law, piece, s, r, more);
    return sum;
}

double dl_law_sum_slope(const dl_law *law, int piece, int first, int terms, double r) {
    double sum = 0;
    for (int s = first; s < first + terms; s++)
        sum -=
            law->coefficient[piece][s] * (law->power[piece][s] + 1) * power_of(law, piece, s, r, 3);
    return sum;
}

int dl_law_piece_within(const dl_law *law, dl_law_range range, double r_squared) {
    int k = dl_law_piece(law, r_squared);
    return k < range.first ? range.first : k > range.last ? range.last : k;
}

double dl_law_force_over_r_in(const dl_law *law, int piece, double r) {
    if (piece == law->pieces)
        return 0;
    return law->width[piece] > 0 ? dl_taper_force_over_r(law, piece, r)
                                 : dl_law_sum(law, piece, 0, law->terms[piece], r, 1);
}

double dl_law_force_over_r_within(const dl_law *law, dl_law_range range, double r_squared) {
    int k = dl_law_piece_within(law, range, r_squared);
    return k == law->pieces ? 0 : dl_law_force_over_r_in(law, k, sqrt(r_squared));
}

double dl_law_jump(const dl_law *law, int piece) {
    double r = law->until[piece];
    if (isinf(r))
        return 0;
    double inside = dl_law_force_over_r_in(law, piece, r);
    double outside = dl_law_force_over_r_in(law, piece + 1, r);
    double roundoff = 1e-9 * fmax(fabs(inside), fabs(outside));
    return fabs(outside - inside) > roundoff ? r * (outside - inside) : 0;
}

double dl_law_force_over_r(const dl_law *law, double r_squared) {
    return dl_law_force_over_r_within(law, dl_law_all(law), r_squared);
}

double dl_law_force_slope(const dl_law *law, double r_squared) {
    return dl_law_force_slope_within(law, dl_law_all(law), r_squared);
}

double dl_law_force_slope_within(const dl_law *law, dl_law_range range, double r_squared) {
    int k = dl_law_piece_within(law, range, r_squared);
    if (k == law->pieces)
        return 0;
    double r = sqrt(r_squared);
    return law->width[k] > 0 ? dl_taper_force_slope(law, k, r)
                             : dl_law_sum_slope(law, k, 0, law->terms[k], r);
}

static double antiderivative(const dl_law *law, int piece, double r) {
    double sum = 0;
    for (int s = 0; s < law->terms[piece]; s++) {
        double c = law->coefficient[piece][s], p = law->power[piece][s];
        sum += p == 1 ? -c * log(r) : c / (p - 1) * (p == 2 ? 1 / r : pow(r, 1 - p));
    }
    return sum;
}

static double potential_in(const dl_law *law, int piece, double r) {
    double until = law->until[piece];
    double change = law->width[piece] > 0
                        ? (until - r) * dl_taper_mean_force(law, piece, r, until, NULL)
                        : antiderivative(law, piece, r);
    return change + law->constant[piece];
}

double dl_law_potential(const dl_law *law, double r_squared) {
    int k = dl_law_piece(law, r_squared);
    return k == law->pieces ? 0 : potential_in(law, k, sqrt(r_squared));
}
