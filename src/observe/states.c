/* Solid, liquid or gas by temperature. */
#include "driftlab/observe.h"

/* TR299, Table IV, as printed (section 3): m_i, v-liquid, v-gas, temp-liquid, temp-gas. */
static const dl_state_threshold table4[] = {
    {10000, 100, 170, 11370, 30200}, {8000, 90, 160, 8190, 22600}, {6000, 78, 140, 4640, 12500},
    {4000, 65, 110, 1160, 5300},     {2000, 50, 80, 710, 2130},
};

const dl_state_table dl_tr299_table4 = {table4, sizeof table4 / sizeof *table4};

static double between(double low, double high, double share) {
    return low + share * (high - low);
}

dl_status dl_state_threshold_at(const dl_state_table *table, double mass,
                                dl_state_threshold *threshold, dl_error *error) {
    const dl_state_threshold *const row = table->row;
    const size_t last = table->rows - 1;
    if (!(mass <= row[0].mass && mass >= row[last].mass))
        return dl_fail(error, DL_INPUT,
                       "states: found a particle of mass %.15g, expected masses from %.15g to "
                       "%.15g, for which there are thresholds",
                       mass, row[last].mass, row[0].mass);
    size_t k = 0;
    while (k < last && mass < row[k].mass)
        k++;
    *threshold = row[k];
    if (mass == row[k].mass)
        return DL_OK;
    const dl_state_threshold *const light = &row[k], *const heavy = &row[k - 1];
    const double share = (mass - light->mass) / (heavy->mass - light->mass);
    *threshold = (dl_state_threshold){
        .mass = mass,
        .v_liquid = between(light->v_liquid, heavy->v_liquid, share),
        .v_gas = between(light->v_gas, heavy->v_gas, share),
        .liquid = between(light->liquid, heavy->liquid, share),
        .gas = between(light->gas, heavy->gas, share),
    };
    return DL_OK;
}

dl_state dl_observe_state(const dl_state_threshold *threshold, double temperature) {
    if (temperature >= threshold->gas)
        return DL_GAS;
    return temperature >= threshold->liquid ? DL_LIQUID : DL_SOLID;
}
