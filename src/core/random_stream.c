#include "core/random_stream.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>

struct dl_random {
    uint64_t origin; /* of seed and item */
    double offset;   /* of the stream */
    gsl_rng *generator;
    gsl_rng rotated; /* the generator's numbers and the offset; its state is this struct */
};

static double rotated_number(void *state) {
    const dl_random *const random = state;
    const double sum = gsl_rng_uniform(random->generator) + random->offset;
    return sum < 1 ? sum : sum - 1;
}

static const gsl_rng_type rotated_type = {.name = "rotated", .get_double = rotated_number};

static uint64_t mix(uint64_t key) {
    key += UINT64_C(0x9e3779b97f4a7c15);
    key = (key ^ (key >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    key = (key ^ (key >> 27)) * UINT64_C(0x94d049bb133111eb);
    return key ^ (key >> 31);
}

dl_status dl_random_create(uint64_t seed, uint64_t item, dl_random **random, dl_error *error) {
    gsl_set_error_handler_off(); /* GSL's default is to abort */
    *random = calloc(1, sizeof **random);
    if (!*random)
        return dl_fail_memory(error, "random numbers");
    (*random)->origin = mix(mix(seed) ^ item);
    (*random)->rotated = (gsl_rng){&rotated_type, *random};
    (*random)->generator = gsl_rng_alloc(gsl_rng_ranlxd2);
    if ((*random)->generator)
        return DL_OK;
    dl_random_free(*random);
    *random = NULL;
    return dl_fail_memory(error, "random numbers");
}

void dl_random_free(dl_random *random) {
    if (!random)
        return;
    if (random->generator)
        gsl_rng_free(random->generator);
    free(random);
}

/* So many streams of an item are the generator's own. */
static const uint64_t unrotated = 4096;

void dl_random_begin(dl_random *random, uint64_t particle, dl_random_use use) {
    const uint64_t key = mix(mix(random->origin ^ particle) ^ (uint64_t)use);
    gsl_rng_set(random->generator, (unsigned long)(key >> 33));
    random->offset = particle < unrotated ? 0 : ldexp((double)(mix(key) >> 11), -53);
}

double dl_random_uniform(dl_random *random, double low, double high) {
    return low + (high - low) * gsl_rng_uniform(&random->rotated);
}

double dl_random_sign(dl_random *random) {
    return gsl_rng_uniform(&random->rotated) < 0.5 ? -1 : 1;
}

double dl_random_normal(dl_random *random) {
    return gsl_ran_gaussian(&random->rotated, 1);
}

void dl_random_direction(dl_random *random, int dimension, double unit_vector[3]) {
    unit_vector[2] = 0;
    if (dimension == 2)
        gsl_ran_dir_2d(&random->rotated, &unit_vector[0], &unit_vector[1]);
    else
        gsl_ran_dir_3d(&random->rotated, &unit_vector[0], &unit_vector[1], &unit_vector[2]);
}
