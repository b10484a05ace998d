/* Symmetric compositions of the Stoermer-Verlet step S_h: kick h/2, drift h, kick h/2.
 *
 *     S_{w_1 h} o S_{w_2 h} o ... o S_{w_s h},    w_j = w_{s+1-j}
 *
 * is symplectic, time-symmetric and conserves both momenta; the w_j make its order. The kicks of
 * neighbouring stages act at one position and are one, so that a step of s stages costs s forces.
 * The last force of a step is the first of the next. */
#include <stdlib.h>
#include <string.h>

#include "methods/options.h"
#include "methods/registry.h"

enum { most_stages = 17 };

/* w_1 ... w_{(s+1)/2}; the others follow by symmetry. */
typedef struct composition_table {
    int stages;
    double weight[(most_stages + 1) / 2];
} composition_table;

static const composition_table verlet_2 = {.stages = 1, .weight = {1}};

/* 1/(2 - 2^(1/3)) and 1 - 2 w_1. H. Yoshida, Phys. Lett. A 150 (1990) 262,
 * doi:10.1016/0375-9601(90)90092-3; also E. Forest, R. D. Ruth, Physica D 43 (1990) 105. */
static const composition_table yoshida_4 = {
    .stages = 3,
    .weight = {1.35120719195965763404768780897, -1.70241438391931526809537561794},
};

/* 1/(4 - 4^(1/3)), twice, and 1 - 4 w_1. M. Suzuki, Phys. Lett. A 146 (1990) 319,
 * doi:10.1016/0375-9601(90)90962-N. */
static const composition_table suzuki_4 = {
    .stages = 5,
    .weight = {0.41449077179437573714235406286, 0.41449077179437573714235406286,
               -0.65796308717750294856941625144},
};

/* Solution A of H. Yoshida (as above), to the digits of E. Hairer, C. Lubich, G. Wanner, Geometric
 * Numerical Integration, 2nd ed. (2006), doi:10.1007/3-540-30666-8, section V.3.2. */
static const composition_table yoshida_6 = {
    .stages = 7,
    .weight = {0.78451361047755726381949763, 0.23557321335935813368479318,
               -1.17767998417887100694641568, 1.31518632068391121888424973},
};

/* W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089, doi:10.1090/S0025-5718-97-00873-9, s9odr6a;
 * Hairer, Lubich, Wanner V.3.2. */
static const composition_table kahan_li_6 = {
    .stages = 9,
    .weight = {0.39216144400731413927925056, 0.33259913678935943859974864,
               -0.70624617255763935980996482, 0.08221359629355080023149045,
               0.79854399093482996339895035},
};

/* M. Suzuki, K. Umeno, in Computer Simulation Studies in Condensed-Matter Physics VI (1993) 74;
 * R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, doi:10.1137/0916010; Hairer, Lubich, Wanner
 * V.3.2. */
static const composition_table suzuki_umeno_8 = {
    .stages = 15,
    .weight = {0.74167036435061295344822780, -0.40910082580003159399730010,
               0.19075471029623837995387626, -0.57386247111608226665638773,
               0.29906418130365592384446354, 0.33462491824529818378495798,
               0.31529309239676659663205666, -0.79688793935291635401978884},
};

/* Kahan, Li (as above), s17odr8a; Hairer, Lubich, Wanner V.3.2. */
static const composition_table kahan_li_8 = {
    .stages = 17,
    .weight = {0.13020248308889008087881763, 0.56116298177510838456196441,
               -0.38947496264484728640807860, 0.15884190655515560089621075,
               -0.39590389413323757733623154, 0.18453964097831570709183254,
               0.25837438768632204729397911, 0.29501172360931029887096624,
               -0.60550853383003451169892108},
};

typedef struct composition_options {
    double step;
} composition_options;

static const dl_parameter options[] = {DL_OPTION_FIXED_STEP(composition_options)};

typedef struct composition {
    int stages;
    double kick[most_stages + 1]; /* parts of the step */
    double drift[most_stages];
    double *a;    /* [unknowns] */
    double *work; /* [2 unknowns]: the state between stages, so that a failure leaves y alone */
    bool a_is_current; /* a is the acceleration at y */
    unsigned long steps;
} composition;

static double weight(const composition_table *table, int stage) {
    const int mirrored = table->stages - 1 - stage;
    return table->weight[stage < mirrored ? stage : mirrored];
}

static dl_status composition_create(dl_method *method, dl_error *error) {
    const composition_table *const table = method->row->variant;
    method->step = ((const composition_options *)method->options)->step;
    composition *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "a composition method");
    data->stages = table->stages;
    double previous = 0;
    for (int i = 0; i < table->stages; i++) {
        const double w = weight(table, i);
        data->kick[i] = (previous + w) / 2;
        data->drift[i] = w;
        previous = w;
    }
    data->kick[table->stages] = previous / 2;
    data->a = malloc(method->n * sizeof *data->a);
    data->work = malloc(2 * method->n * sizeof *data->work);
    return data->a && data->work ? DL_OK : dl_fail_memory(error, "a composition's stages");
}

/* v = v_old + kick a, q = q_old + drift v. The new may be the old. */
static void kick_and_drift(size_t n, double kick, double drift, const double *a,
                           const double *q_old, const double *v_old, double *q, double *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = v_old[i] + kick * a[i];
        q[i] = q_old[i] + drift * v[i];
    }
}

static dl_status composition_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    composition *const data = method->data;
    const size_t n = method->n;
    const double h = method->step;
    double *const q = method->y, *const v = q + n, *const q_work = data->work,
                  *const v_work = q_work + n;
    dl_status status = DL_OK;
    if (!data->a_is_current)
        status = dl_model_acceleration(method->model, q, data->a, error);
    data->a_is_current = false;
    for (int i = 0; i < data->stages && !status; i++) {
        kick_and_drift(n, data->kick[i] * h, data->drift[i] * h, data->a, i ? q_work : q,
                       i ? v_work : v, q_work, v_work);
        status = dl_model_acceleration(method->model, q_work, data->a, error);
    }
    if (status)
        return status;
    memcpy(q, q_work, n * sizeof *q);
    for (size_t i = 0; i < n; i++)
        v[i] = v_work[i] + data->kick[data->stages] * h * data->a[i];
    data->a_is_current = true;
    data->steps++;
    dl_method_count_step(method);
    return DL_OK;
}

static dl_status composition_jumped(dl_method *method, dl_error *error) {
    (void)error;
    ((composition *)method->data)->a_is_current = false;
    return DL_OK;
}

static void composition_stats(const dl_method *method, dl_method_stats *stats) {
    stats->steps = ((const composition *)method->data)->steps;
}

static void composition_destroy(dl_method *method) {
    composition *const data = method->data;
    if (data) {
        free(data->a);
        free(data->work);
    }
    free(data);
}

static const dl_method_ops ops = {
    .create = composition_create,
    .advance = composition_advance,
    .jumped = composition_jumped,
    .stats = composition_stats,
    .destroy = composition_destroy,
};

#define COMPOSITION(symbol, name_, order_, table, doc_)                                            \
    const dl_method_row dl_method_composition_##symbol = {                                         \
        .name = name_,                                                                             \
        .family = "composition",                                                                   \
        .doc = doc_,                                                                               \
        .order = order_,                                                                           \
        .flags = DL_SYMPLECTIC | DL_TIME_SYMMETRIC | DL_CONSERVES_MOMENTUM | DL_FIXED_STEP |       \
                 DL_RESTARTS_EXACTLY,                                                              \
        .options = DL_OPTIONS_TABLE(options),                                                      \
        .options_size = sizeof(composition_options),                                               \
        .variant = &(table),                                                                       \
        .ops = &ops,                                                                               \
    }

COMPOSITION(2_verlet, "composition-2-verlet", 2, verlet_2,
            "velocity Verlet: one stage (Verlet 1967, doi:10.1103/PhysRev.159.98)");
COMPOSITION(4_yoshida, "composition-4-yoshida", 4, yoshida_4,
            "3 stages (Forest & Ruth 1990; Yoshida 1990, doi:10.1016/0375-9601(90)90092-3)");
COMPOSITION(4_suzuki, "composition-4-suzuki", 4, suzuki_4,
            "5 stages (Suzuki 1990, doi:10.1016/0375-9601(90)90962-N)");
COMPOSITION(6_yoshida, "composition-6-yoshida", 6, yoshida_6,
            "7 stages, solution A (Yoshida 1990, doi:10.1016/0375-9601(90)90092-3)");
COMPOSITION(6_kahan_li, "composition-6-kahan-li", 6, kahan_li_6,
            "9 stages (Kahan & Li 1997, doi:10.1090/S0025-5718-97-00873-9)");
COMPOSITION(8_suzuki_umeno, "composition-8-suzuki-umeno", 8, suzuki_umeno_8,
            "15 stages (Suzuki & Umeno 1993; McLachlan 1995, doi:10.1137/0916010)");
COMPOSITION(8_kahan_li, "composition-8-kahan-li", 8, kahan_li_8,
            "17 stages (Kahan & Li 1997, doi:10.1090/S0025-5718-97-00873-9)");
