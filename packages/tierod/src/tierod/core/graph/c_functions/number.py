"""C of the real type: its constants, its bits, exact sums and products, and polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Real(NamedTuple):
    """Properties of a floating-point type that the functions depend on.

    Args:
        fraction: number of stored bits of its significand
    """

    name: str
    suffix: str
    word: str
    fraction: int
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
