#include "reference/extended/gauss_table.h"

#include <stdlib.h>

/* P_0(x) ... P_top(x). */
static void legendre(real x, int top, real *p) {
    p[0] = 1;
    p[1] = x;
    for (int m = 1; m < top; m++)
        p[m + 1] = ((2 * m + 1) * x * p[m] - m * p[m - 1]) / (m + 1);
}

static void find_nodes(gauss_table *table) {
    const int s = table->stages;
    real p[gauss_most_stages + 4];
    for (int i = 0; i < s; i++) {
        real x = -real_cos((real)3.14159265358979323846 * (i + (real)3 / 4) / (s + (real)1 / 2));
        real slope = 1;
        for (int iteration = 0; iteration < 8; iteration++) {
            legendre(x, s, p);
            slope = s * (x * p[s] - p[s - 1]) / (x * x - 1);
            x -= p[s] / slope;
        }
        table->node[i] = (1 + x) / 2;
        table->weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
}

/* Of P_m(2 tau - 1): its integral from 0, and the integral of that, for m = 0 ... top. */
static void integrate(real tau, int top, real *twice) {
    real p[gauss_most_stages + 4], once[gauss_most_stages + 4];
    legendre(2 * tau - 1, top + 2, p);
    once[0] = tau;
    for (int m = 1; m <= top + 1; m++)
        once[m] = (p[m + 1] - p[m - 1]) / (2 * (2 * m + 1));
    twice[0] = tau * tau / 2;
    for (int m = 1; m <= top; m++)
        twice[m] = (once[m + 1] - once[m - 1]) / (2 * (2 * m + 1));
}

static void fill_legendre(gauss_table *table) {
    const int s = table->stages;
    real p[gauss_most_stages + 4];
    for (int i = 0; i < s; i++) {
        legendre(2 * table->node[i] - 1, s, p);
        for (int m = 0; m < s; m++)
            table->legendre[m * s + i] = (2 * m + 1) * table->weight[i] * p[m];
    }
}

static void fill_places(gauss_table *table) {
    const int s = table->stages;
    real twice[gauss_most_stages + 4];
    for (int i = 0; i < s; i++) {
        integrate(table->node[i], s - 1, twice);
        for (int j = 0; j < s; j++) {
            real sum = 0;
            for (int m = 0; m < s; m++)
                sum += twice[m] * table->legendre[m * s + j];
            table->place[i * s + j] = sum;
        }
    }
}

/* P_m(2 tau - 1) = sum_k (-1)^(m + k) C(m, k) C(m + k, k) tau^k. */
static void fill_powers(gauss_table *table) {
    const int s = table->stages;
    for (int m = 0; m < s; m++) {
        real factor = m % 2 ? -1 : 1;
        for (int k = 0; k <= m; k++) {
            for (int j = 0; j < s; j++)
                table->power[k * s + j] += factor * table->legendre[m * s + j];
            factor *= -(real)((m - k) * (m + k + 1)) / ((k + 1) * (k + 1));
        }
    }
}

dl_status gauss_table_create(int stages, gauss_table *table, dl_error *error) {
    const size_t s = (size_t)stages;
    *table = (gauss_table){.stages = stages};
    table->node = calloc(s, sizeof *table->node);
    table->weight = calloc(s, sizeof *table->weight);
    table->place = calloc(s * s, sizeof *table->place);
    table->legendre = calloc(s * s, sizeof *table->legendre);
    table->power = calloc(s * s, sizeof *table->power);
    if (!table->node || !table->weight || !table->place || !table->legendre || !table->power)
        return dl_fail_memory(error, "a collocation method");
    find_nodes(table);
    fill_legendre(table);
    fill_places(table);
    fill_powers(table);
    return DL_OK;
}

void gauss_table_free(gauss_table *table) {
    free(table->node);
    free(table->weight);
    free(table->place);
    free(table->legendre);
    free(table->power);
    *table = (gauss_table){.stages = 0};
}
