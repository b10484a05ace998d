/* Random numbers of initial states: one seed, and from it a stream for every particle, so that a
 * particle's numbers depend neither on how many others there are nor on their order.
 *
 *     key = mix(mix(mix(mix(seed) ^ item) ^ particle) ^ use)
 *
 * where mix is the output function of SplitMix64 (Steele, Lea and Flood, 2014,
 * doi:10.1145/2660193.2660195), `item` the place of the particle's item in the scene's list (0
 * where the item has a seed of its own), `particle` its place in the item, and `use` says what the
 * numbers are for. The upper 31 bits of the key seed GSL's generator ranlxd2 (Luescher, 1994,
 * doi:10.1016/0010-4655(94)90232-1), whose numbers have 48 bits and are the same on every machine.
 * Of 4096 streams with 31 bits two are the same in one scene of 250; of a hundred thousand some are
 * for certain. From the 4096th particle on every number u is therefore rotated as well:
 *
 *     (u + offset) mod 1,   offset = upper 53 bits of mix(key) / 2^53
 */
#ifndef DL_CORE_RANDOM_STREAM_H
#define DL_CORE_RANDOM_STREAM_H

#include <stdint.h>
#include "driftlab/status.h"

typedef enum dl_random_use {
    DL_RANDOM_POSITION,
    DL_RANDOM_MOTION, /* speed, temperature */
    DL_RANDOM_PERTURBATION,
    DL_RANDOM_ROTATION,
    DL_RANDOM_MASS,
} dl_random_use;

typedef struct dl_random dl_random;

dl_status dl_random_create(uint64_t seed, uint64_t item, dl_random **random, dl_error *error);
void dl_random_free(dl_random *random); /* NULL will do */

/* What follows is drawn from the start of this stream. */
void dl_random_begin(dl_random *random, uint64_t particle, dl_random_use use);

double dl_random_uniform(dl_random *random, double low, double high); /* in [low, high) */
double dl_random_sign(dl_random *random);                             /* -1 or 1 */
double dl_random_normal(dl_random *random);                           /* variance 1 */
void dl_random_direction(dl_random *random, int dimension, double unit_vector[3]);

#endif
