/* Doubles as HDF5's filters shuffle and deflate leave them, but fast: the n-th bytes of all numbers
 * lie together, a plane, and planes that are noise, the low bytes of a moving particle's position,
 * are stored. zlib at its fastest takes ten times as long for finding out that it cannot shorten
 * them. Any reader of HDF5 undoes it. */
#ifndef DL_IO_PLANES_H
#define DL_IO_PLANES_H

#include <stddef.h>

/* Compresses values [count]; *bytes is the caller's. Returns how many; 0: no memory. */
size_t dl_planes_deflate(const double *values, size_t count, unsigned char **bytes);

#endif
