"""Real numbers in printed C: types, constants, bits, and the reduction of angles."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple


class Real(NamedTuple):
    """Properties of a floating-point type that the functions depend on."""

    name: str
    suffix: str
    word: str
    fraction: int  # number of stored bits of its significand
    bias: int
    least: float

    def number(self, value: float) -> str:
        """A constant as C writes it."""
        return f"{value!r}{self.suffix}" if value >= 0.0 else f"(-{-value!r}{self.suffix})"


DOUBLE = Real("double", "", "uint64_t", 52, 1023, 2.0**-1022)
FLOAT = Real("float", "f", "uint32_t", 23, 127, 2.0**-126)

HEAD = """\
#include <math.h>
#include <stdint.h>
#include <string.h>
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
#ifdef TIEROD_FAST_FMA
#define tierod_fma(a, b, c) M(fma)(a, b, c)
#else
#define tierod_fma(a, b, c) ((a) * (b) + (c))
#endif
"""
"""First lines of every kernel."""

INLINE = """\
#ifndef TIEROD_INLINE
#define TIEROD_INLINE static inline
#endif
"""
ALWAYS_INLINE = """\
#ifdef __GNUC__
#define TIEROD_INLINE static inline __attribute__((always_inline))
#endif
"""
"""Forced inlining for loops over lanes, which do not vectorise while one call is left."""

FUSED = {"fma": "tierod_fma({0}, {1}, {2})", "fms": "tierod_fma({0}, {1}, -{2})", "fnma": "tierod_fma(-{0}, {1}, {2})"}

SIGN = "TIEROD_INLINE real tierod_sign(real a) { return a > R(0.0) ? R(1.0) : a < R(0.0) ? -R(1.0) : a; }\n"


def bits(real: Real) -> str:
    """C of the bits of a number, of rounding to whole numbers, of powers of two, and of the sign."""
    whole = real.number(1.5 * 2.0**real.fraction)
    return f"""\
typedef {real.word} tierod_word;
#define TIEROD_WHOLE {whole} /* a sum with it holds a whole number in its lowest bits */
#define TIEROD_SIGN ((tierod_word)1 << {real.fraction + real.bias.bit_length() + 1})
TIEROD_INLINE tierod_word tierod_bits(real x) {{ tierod_word b; memcpy(&b, &x, sizeof b); return b; }}
TIEROD_INLINE real tierod_number(tierod_word b) {{ real x; memcpy(&x, &b, sizeof x); return x; }}
/* 2^k of a whole number whose power is a normal number. */
TIEROD_INLINE real tierod_power_of_two(real k) {{
    return tierod_number((tierod_bits(k + TIEROD_WHOLE) + {real.bias}) << {real.fraction});
}}
/* The size of a with the sign of b. */
TIEROD_INLINE real tierod_signed(real a, real b) {{
    return tierod_number((tierod_bits(a) & ~TIEROD_SIGN) | (tierod_bits(b) & TIEROD_SIGN));
}}
"""


def exact(real: Real) -> str:
    """C of the rounding errors of a sum and of a product."""
    splitter = real.number(2.0 ** ((real.fraction + 2) // 2) + 1.0)
    return f"""\
/* What the sum s = a + b lost (Knuth). */
TIEROD_INLINE real tierod_sum_error(real a, real b, real s) {{
    const real t = s - a;
    return (a - (s - t)) + (b - t);
}}
/* What the product p = a * b lost (Dekker, where there is no fused operation). */
TIEROD_INLINE real tierod_product_error(real a, real b, real p) {{
#ifdef TIEROD_FAST_FMA
    return M(fma)(a, b, -p);
#else
    const real c = {splitter} * a, d = {splitter} * b;
    const real ah = c - (c - a), bh = d - (d - b), al = a - ah, bl = b - bh;
    return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
#endif
}}
"""


def polynomial(real: Real, result: str, variable: str, coefficients: Sequence[float], indent: str = "    ") -> str:
    """C that evaluates a polynomial in pairs (Estrin's scheme), which is a short chain of operations.

    Args:
        result: name of the constant that receives the value
    """
    terms = [real.number(value) for value in coefficients]
    lines: list[str] = []
    power, level = variable, 0
    while len(terms) > 1:
        pairs = [f"tierod_fma({b}, {power}, {a})" for a, b in zip(terms[::2], terms[1::2], strict=False)]
        names = [f"{result}{level}_{k}" for k in range(len(pairs))]
        if len(terms) == 2:
            return "".join(lines) + f"{indent}const real {result} = {pairs[0]};\n"
        lines += [f"{indent}const real {name} = {pair};\n" for name, pair in zip(names, pairs, strict=True)]
        terms = names + (terms[-1:] if len(terms) % 2 else [])
        lines.append(f"{indent}const real {result}x{level} = {power} * {power};\n")
        power, level = f"{result}x{level}", level + 1
    return "".join(lines) + f"{indent}const real {result} = {terms[0]};\n"


_PIECES = {
    DOUBLE: (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32),
    FLOAT: (1.5703125, 0.0004837512969970703, 7.549533620476723e-08, 2.563344151594519e-12),
}
"""Pi/2 as a sum of pieces: the products of the first three with a whole number of quarter turns below `_LARGEST` are
exact. All are positive, which keeps the sign of a zero angle."""

_LARGEST = {DOUBLE: 1.0e6, FLOAT: 5.0e3}  # Largest angle that is reduced with the pieces [rad]

_WINDOWS, _STEP = 63, 16
"""Number of windows of the digits of 2/pi, and powers of two that each serves, from 2^20 to the largest double."""


def reduction(real: Real) -> str:
    """C of `tierod_reduced`: angle -> number of quarter turns, and the rest as a sum of two numbers."""
    first, second, third, last = map(real.number, _PIECES[real])
    far = _far_double() if real is DOUBLE else _far_float()
    return (
        far
        + f"""\
/* x less the nearest whole number of quarter turns, as rest + tail; the lowest two bits count the quarter turns. */
TIEROD_INLINE tierod_word tierod_reduced(real x, real *rest, real *tail) {{
    const real shifted = tierod_fma(x, {real.number(0.6366197723675814)}, TIEROD_WHOLE), k = shifted - TIEROD_WHOLE;
    const real r1 = x - k * {first}, w2 = -(k * {second}), w3 = -(k * {third});
    const real r2 = r1 + w2, r3 = r2 + w3;
    const real e = tierod_sum_error(r1, w2, r2) + tierod_sum_error(r2, w3, r3);
    tierod_word turns = tierod_bits(shifted);
    *rest = r3;
    *tail = e - k * {last};
    if (!(M(fabs)(x) <= {real.number(_LARGEST[real])}))
        turns = tierod_far_reduced(x, rest, tail);
    return turns;
}}
"""
    )


def _far_double() -> str:
    """C that reduces large angles with those digits of 2/pi that do not give whole turns (Payne and Hanek)."""
    table = ",\n    ".join(", ".join(part.hex() for part in row) for row in _parts())
    return f"""\
/* 2/pi times 2^({_STEP} i), less whole turns, in four parts. */
static const real tierod_turns[] = {{
    {table}
}};
TIEROD_INLINE tierod_word tierod_far_reduced(real x, real *rest, real *tail) {{
    const tierod_word size = tierod_bits(x) & ~TIEROD_SIGN;
    const tierod_word above = (size >> 52) - 1043, row = above > 1003 ? 0 : above / {_STEP};
    const real m = tierod_number(size - (row * {_STEP} << 52));
    const real *t = &tierod_turns[row * 4];
    const real p0 = m * t[0], p1 = m * t[1], p2 = m * t[2];
    const real q0 = tierod_product_error(m, t[0], p0), q1 = tierod_product_error(m, t[1], p1);
    const real q2 = tierod_product_error(m, t[2], p2);
    const real huge = 7083549724304467820544.0, four = 27021597764222976.0; /* 1.5 * 2^72, 1.5 * 2^54 */
    const real f = p0 - ((p0 + huge) - huge), f0 = f - ((f + four) - four), f1 = q0 - ((q0 + four) - four);
    const real f2 = p1 - ((p1 + four) - four);
    const real s1 = f0 + f1, s2 = s1 + f2, shifted = s2 + TIEROD_WHOLE, a = s2 - (shifted - TIEROD_WHOLE);
    const real l = tierod_sum_error(f0, f1, s1) + tierod_sum_error(s1, f2, s2);
    const real b1 = q1 + p2, b2 = l + b1, h = a + b2;
    const real low = tierod_sum_error(a, b2, h) + (tierod_sum_error(q1, p2, b1) + tierod_sum_error(l, b1, b2)
        + (q2 + m * t[3]));
    const real r = h * 1.5707963267948966;
    const real e = tierod_product_error(h, 1.5707963267948966, r)
        + (h * 6.123233995736766e-17 + low * 1.5707963267948966);
    *rest = x < 0.0 ? -r : r;
    *tail = x < 0.0 ? -e : e;
    return x < 0.0 ? 0 - tierod_bits(shifted) : tierod_bits(shifted);
}}
"""


def _far_float() -> str:
    """The same for float, in integers: 24 bits of the angle times 96 bits of 2/pi."""
    digits = _two_over_pi(224)
    table = ", ".join(f"0x{digits >> (224 - 32 * k) & 0xFFFFFFFF:08x}u" for k in range(8))
    scale = 1.5707963267948966 * 2.0**-62
    return f"""\
/* 32 zeros, and the first 224 digits of 2/pi. */
static const uint32_t tierod_turns[] = {{ {table} }};
TIEROD_INLINE tierod_word tierod_far_reduced(real x, real *rest, real *tail) {{
    const uint32_t size = tierod_bits(x) & ~TIEROD_SIGN, e = size >> 23, far = e < 120 || e > 254 ? 0 : e - 120;
    const uint64_t m = (size & 0x7fffff) | 0x800000;
    const uint32_t *t = &tierod_turns[far / 32], down = 32 - far % 32;
    const uint32_t a0 = (uint32_t)((((uint64_t)t[0] << 32) | t[1]) >> down);
    const uint32_t a1 = (uint32_t)((((uint64_t)t[1] << 32) | t[2]) >> down);
    const uint32_t a2 = (uint32_t)((((uint64_t)t[2] << 32) | t[3]) >> down);
    const uint64_t part = ((m * a0) << 32) + m * a1 + ((m * a2) >> 32); /* of a turn, times 2^64 */
    const uint64_t turns = (part + ((uint64_t)1 << 61)) >> 62;
    const int64_t left = (int64_t)(part - (turns << 62));
    const real h = (real)left, low = (real)(left - (int64_t)h);
    const real r = h * {FLOAT.number(_rounded(scale))};
    const real e_r = tierod_product_error(h, {FLOAT.number(_rounded(scale))}, r)
        + (h * {FLOAT.number(scale - _rounded(scale))} + low * {FLOAT.number(_rounded(scale))});
    const real nothing = x - x; /* NaN of an infinite angle */
    *rest = (x < 0.0f ? -r : r) + nothing;
    *tail = x < 0.0f ? -e_r : e_r;
    return (tierod_word)(x < 0.0f ? 0 - turns : turns);
}}
"""


def _rounded(value: float) -> float:
    return float(struct.unpack("f", struct.pack("f", value))[0])


def _parts() -> list[list[float]]:
    """Four parts, of 53 digits each, of 2/pi times 2^(16 i), modulo 2^34.

    2^34 quarter turns times the last digit of an angle are whole turns, and drop out.
    """
    digits = _two_over_pi(_STEP * _WINDOWS + 178)
    rows = []
    for window in range(_WINDOWS):
        row = digits >> (_STEP * (_WINDOWS - window)) & (1 << 212) - 1
        rows.append([math.ldexp(float(row >> (159 - 53 * k) & (1 << 53) - 1), -19 - 53 * k) for k in range(4)])
    return rows


@cache
def _two_over_pi(bits: int) -> int:
    """2/pi times 2^bits, truncated."""
    guard = bits + 64
    one = 1 << guard
    pi = 4 * (4 * _arctan_of_inverse(5, one) - _arctan_of_inverse(239, one))  # Machin
    return 2 * one * one // pi >> 64


def _arctan_of_inverse(n: int, one: int) -> int:
    """arctan(1/n) in units of 1/one."""
    total, power, k = 0, one // n, 0
    while power:
        total += (-1) ** k * (power // (2 * k + 1))
        power, k = power // (n * n), k + 1
    return total
