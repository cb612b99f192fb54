"""The C that every kernel begins with: one real type, and the functions that we write ourselves.

The exponential function is ours and without a branch, so that the loop over lanes vectorises where it occurs; it is the
same in every driver. The other transcendental functions are those of the C library, likewise in every driver.
"""

from __future__ import annotations

_HEAD = """\
#include <math.h>
#include <stdint.h>
#ifdef TIEROD_FLOAT32
typedef float real;
#define R(x) x##f
#define M(name) name##f
#ifdef FP_FAST_FMAF
#define TIEROD_FAST_FMA
#endif
#else
typedef double real;
#define R(x) x
#define M(name) name
#ifdef FP_FAST_FMA
#define TIEROD_FAST_FMA
#endif
#endif
"""
_FMA = """\
#ifdef TIEROD_FAST_FMA
#define tierod_fma(a, b, c) M(fma)(a, b, c)
#else
#define tierod_fma(a, b, c) ((a) * (b) + (c))
#endif
"""
FUSED = {"fma": "tierod_fma({0}, {1}, {2})", "fms": "tierod_fma({0}, {1}, -{2})", "fnma": "tierod_fma(-{0}, {1}, {2})"}
_SIGN = "static inline real tierod_sign(real a) { return a > R(0.0) ? R(1.0) : a < R(0.0) ? -R(1.0) : a; }\n"
_EXP = """\
#ifdef TIEROD_FLOAT32
#define tierod_exp(x) M(exp)(x)
#else
static inline real tierod_exp(real x) {
    const real whole = 6755399441055744.0; /* 1.5 * 2^52: a sum with it holds a whole number in its lowest bits */
    const real y = x > 710.0 ? 710.0 : x < -708.0 ? -708.0 : x;
    union { double number; uint64_t bits; } scale;
    scale.number = tierod_fma(y, 1.4426950408889634, whole);
    const real k = scale.number - whole;
    const real r = tierod_fma(-k, 1.90821492927058770002e-10, tierod_fma(-k, 6.93147180369123816490e-01, y));
    real p = 1.6059043836821613e-10;
    p = tierod_fma(p, r, 2.08767569878681e-09);
    p = tierod_fma(p, r, 2.505210838544172e-08);
    p = tierod_fma(p, r, 2.755731922398589e-07);
    p = tierod_fma(p, r, 2.7557319223985893e-06);
    p = tierod_fma(p, r, 2.48015873015873e-05);
    p = tierod_fma(p, r, 0.0001984126984126984);
    p = tierod_fma(p, r, 0.001388888888888889);
    p = tierod_fma(p, r, 0.008333333333333333);
    p = tierod_fma(p, r, 0.041666666666666664);
    p = tierod_fma(p, r, 0.16666666666666666);
    p = tierod_fma(p, r, 0.5);
    p = tierod_fma(p, r, 1.0);
    p = tierod_fma(p, r, 1.0);
    scale.bits = (scale.bits << 52) + ((uint64_t)1022 << 52); /* 2^(k - 1), so that the largest results fit */
    const real e = p * scale.number * 2.0;
    return x < -707.0 ? 0.0 : x > 709.782712893384 ? (real)INFINITY : e;
}
#endif
"""

PRELUDE = _HEAD + _FMA + _SIGN + _EXP
"""Stands at the head of every kernel."""

OWN = {"sign": "tierod_sign", "exp": "tierod_exp"}
"""Functions of ours, by the name of the operation."""
