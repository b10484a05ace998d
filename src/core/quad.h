/* Quad precision: __float128 and libquadmath, whose header lies where only GCC looks. */
#ifndef DL_CORE_QUAD_H
#define DL_CORE_QUAD_H

#ifndef __clang__
#include <quadmath.h>
#else
#include <stddef.h>
__float128 sqrtq(__float128 x);
__float128 powq(__float128 x, __float128 y);
__float128 sinq(__float128 x);
__float128 cosq(__float128 x);
__float128 rintq(__float128 x);
__float128 fabsq(__float128 x);
__float128 strtoflt128(const char *text, char **end);
int quadmath_snprintf(char *text, size_t size, const char *format, ...);
#endif

#endif
