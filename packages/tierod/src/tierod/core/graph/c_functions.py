"""The C that every kernel begins with: one real type, and tierod's own mathematical functions, written in functions.c.

Only square root, absolute value and rounding, which are instructions, are taken from the C library. The functions have
no branch, so that a loop over lanes vectorises where they occur, and are the same in every driver. Their error is at
most two units in the last place."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
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

# Coefficients: in double of Sun's fdlibm (k_sin.c, k_cos.c, s_atan.c, e_log.c) and Taylor series, in float of Moshier's
# Cephes (sinf, atanf, expf) and fdlibm (e_logf.c). EXPONENTIAL is of (exp(r) - 1 - r) / r^2, LOGARITHM of
# (log(1 + f) - 2 s) / s^3 with s = f / (2 + f), TANH, of Cephes, of (tanh(x) - x) / x^3, SINH of (sinh(x) - x) / x^3.
_SINH = tuple(1.0 / math.factorial(2 * n + 1) for n in range(1, 10))
_COEFFICIENTS = {
    DOUBLE: {
        "SINE": (
            -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
            2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
        ),
        "COSINE": (
            4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
            -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
        ),
        "ARCTANGENT": (
            -3.33333333333329318027e-01, 1.99999999998764832476e-01, -1.42857142725034663711e-01,
            1.11111104054623557880e-01, -9.09088713343650656196e-02, 7.69187620504482999495e-02,
            -6.66107313738753120669e-02, 5.83357013379057348645e-02, -4.97687799461593236017e-02,
            3.65315727442169155270e-02, -1.62858201153657823623e-02,
        ),
        "EXPONENTIAL": tuple(1.0 / math.factorial(n) for n in range(2, 14)),
        "LOGARITHM": (
            6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
            1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
        ),
        "TANH_ABOVE": (-1.61468768441708447952e3, -9.92877231001918586564e1, -9.64399179425052238628e-1),
        "TANH_BELOW": (4.84406305325125486048e3, 2.23548839060100448583e3, 1.12811678491632931402e2, 1.0),
        "SINH": _SINH,
        "POWER": tuple(2.0 / (2 * n + 1) for n in range(2, 14)),
    },
    FLOAT: {
        "SINE": (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4),
        "COSINE": (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5),
        "ARCTANGENT": (-3.33329491539e-1, 1.99777106478e-1, -1.38776856032e-1, 8.05374449538e-2),
        "EXPONENTIAL": (
            5.0000001201e-1, 1.6666665459e-1, 4.1665795894e-2, 8.3334519073e-3, 1.3981999507e-3, 1.9875691500e-4,
        ),
        "LOGARITHM": (0.66666662693, 0.40000972152, 0.28498786688, 0.24279078841),
        "TANH_ABOVE": (
            -3.33332819422e-1, 1.33314422036e-1, -5.37397155531e-2, 2.06390887954e-2, -5.70498872745e-3,
        ),
        "TANH_BELOW": (1.0,),
        "SINH": _SINH[:5],
        "POWER": tuple(2.0 / (2 * n + 1) for n in range(2, 7)),
    },
}  # fmt: skip


@cache
def _constants(real: Real) -> dict[str, str]:
    """C of each constant by the name that stands for it."""
    double = real is DOUBLE
    fraction, bias = real.fraction, real.bias
    # The angle scales and the pieces of pi/2: products of the first three pieces with a whole number of quarter turns
    # below LARGEST_ANGLE are exact; all are positive, which keeps the sign of a zero angle. Further constants are the
    # nearest number and what it lacks.
    numbers = {
        "WHOLE": 1.5 * 2.0**fraction, "SPLITTER": 2.0 ** ((fraction + 2) // 2) + 1.0, "TWO_OVER_PI": 0.6366197723675814,
        "LEAST": real.least, "SUBNORMAL_UP": 2.0 ** (fraction + 2), "SUBNORMAL_BIAS": bias + fraction + 2.0,
        "BIAS": float(bias), "SQRT_HALF": math.sqrt(0.5), "MOST_HALVINGS": float(fraction + 10),
        "WHOLE_FROM": 2.0**fraction, "LARGEST_POWER": 2.0**66, "LARGEST_ANGLE": 1.0e6 if double else 5.0e3,
        "LOWEST": -745.2 if double else -104.0, "HIGHEST": 709.782712893384 if double else 88.72283172607422,
    }  # fmt: skip
    pairs = {
        "LN2": ((6.93147180369123816490e-01, 1.90821492927058770002e-10), (0.693359375, -2.12194440e-4)),
        "ATAN_HALF": ((0.4636476090008061, 2.2698777452961687e-17), (0.46364760398864746, 5.01215868808913e-09)),
        "PI_4": ((0.7853981633974483, 3.061616997868383e-17), (0.7853981852531433, -2.1855694143368964e-08)),
        "PI": ((3.141592653589793, 1.2246467991473532e-16), (3.1415927410125732, -8.742277657347586e-08)),
        "TWO_THIRDS": ((0.6666666666666666, 3.700743415417188e-17), (0.6666666865348816, -1.9868215517249155e-08)),
    }
    for name, both in pairs.items():
        numbers[name], numbers[f"{name}_LOW"] = both[0 if double else 1]
    numbers |= {"PI_2": 0.5 * numbers["PI"], "PI_2_LOW": 0.5 * numbers["PI_LOW"]}
    pieces = (
        (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32) if double
        else (1.5703125, 0.0004837512969970703, 7.549533620476723e-08, 2.563344151594519e-12)
    )  # fmt: skip
    numbers |= {f"QUARTER_{place}": piece for place, piece in enumerate(pieces, 1)}
    for name, exponents in {
        "ANGLE": (900, -900, 200, -200) if double else (100, -100, 50, -50),
        "LENGTH": (500, -450, 600, -600) if double else (60, -50, 80, -80),
    }.items():
        sizes = zip(("LARGE", "SMALL", "UP", "DOWN"), exponents, strict=True)
        numbers |= {f"{name}_{size}": 2.0**exponent for size, exponent in sizes}
    scale = 1.5707963267948966 * 2.0**-62
    rounded = float(struct.unpack("f", struct.pack("f", scale))[0])
    numbers |= {"EIGHTH": rounded, "EIGHTH_LOW": scale - rounded}
    counts = {"WORD": real.word, "FRACTION": fraction, "BIAS_COUNT": bias, "SIGN_BIT": fraction + bias.bit_length() + 1}
    texts = {name: str(count) for name, count in counts.items()}
    return {name: real.number(value) for name, value in numbers.items()} | texts | {"TURNS": _turns(double)}


# First lines of every kernel
_HEAD = """\
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

_INLINE = """\
#ifndef TIEROD_INLINE
#define TIEROD_INLINE static inline
#endif
"""
# Forced inlining for loops over lanes, which do not vectorise while one call is left
_ALWAYS_INLINE = """\
#ifdef __GNUC__
#define TIEROD_INLINE static inline __attribute__((always_inline))
#endif
"""

FUSED = {"fma": "tierod_fma({0}, {1}, {2})", "fms": "tierod_fma({0}, {1}, -{2})", "fnma": "tierod_fma(-{0}, {1}, {2})"}

_SIGN = "TIEROD_INLINE real tierod_sign(real a) { return a > R(0.0) ? R(1.0) : a < R(0.0) ? -R(1.0) : a; }\n"

# Parts that each group of functions needs, in order
_PARTS = {
    "circular": ("bits", "exact", "far", "reduction", "circular"),
    "arctangent": ("bits", "exact", "arctangent"),
    "exponential": ("bits", "exact", "exponential"),
    "logarithm": ("bits", "exact", "logarithm"),
    "power": ("bits", "exact", "exponential", "logarithm", "power"),
    "length": ("length",),
}
_GROUPS = {
    **dict.fromkeys(("sin", "cos", "tan"), "circular"),
    **dict.fromkeys(("asin", "acos", "atan", "atan2"), "arctangent"),
    **dict.fromkeys(("exp", "expm1", "sinh", "cosh", "tanh"), "exponential"),
    **dict.fromkeys(("log", "log1p"), "logarithm"),
    "pow": "power",
    "hypot": "length",
}

# Names of tierod's own C functions, by the name of the operation
OWN = {name: f"tierod_{name}" for name in ("sign", *_GROUPS)}


def prelude(operations: Iterable[str], in_lanes: bool = False) -> str:
    """Head of a kernel: types, and the functions that the kernel uses, in double and in float."""
    wanted = list(operations)
    head = _HEAD + (_ALWAYS_INLINE if in_lanes else "") + _INLINE + _SIGN
    if not any(name in _GROUPS for name in wanted):
        return head
    single, double = (definitions(wanted, single) for single in (True, False))
    return f"{head}#ifdef TIEROD_FLOAT32\n{single}#else\n{double}#endif\n"


def definitions(operations: Iterable[str], single: bool) -> str:
    """The functions alone, in one precision; `tierod_fma`, which multiplies and adds, is left to the caller."""
    groups = {_GROUPS[name] for name in operations if name in _GROUPS}
    wanted = {part for group in groups for part in _PARTS[group]}
    ordered = dict.fromkeys(part for parts in _PARTS.values() for part in parts if part in wanted)
    return "".join(_part(name, FLOAT if single else DOUBLE) for name in ordered)


@cache
def _part(name: str, real: Real) -> str:
    texts = re.split(r"\n/\*\*\* ([\w ]+) \*\*\*/\n", Path(__file__).with_name("functions.c").read_text("utf-8"))
    parts = dict(zip(texts[1::2], texts[2::2], strict=True))
    text = parts[f"far {real.name}" if name == "far" else name].rstrip("\n") + "\n"
    text = re.sub(r"@POLYNOMIAL (\w) (\w) (\w+)@\n", lambda found: _polynomial(real, *found.groups()), text)
    return re.sub(r"@(\w+)@", lambda found: _constants(real)[found[1]], text)


def _polynomial(real: Real, result: str, variable: str, coefficients: str) -> str:
    """C that evaluates a polynomial in pairs (Estrin's scheme), which is a short chain of operations."""
    terms: Sequence[str] = [real.number(value) for value in _COEFFICIENTS[real][coefficients]]
    lines: list[str] = []
    power, level = variable, 0
    while len(terms) > 1:
        pairs = [f"tierod_fma({b}, {power}, {a})" for a, b in zip(terms[::2], terms[1::2], strict=False)]
        names = [f"{result}{level}_{k}" for k in range(len(pairs))]
        if len(terms) == 2:
            return "".join(lines) + f"    const real {result} = {pairs[0]};\n"
        lines += [f"    const real {name} = {pair};\n" for name, pair in zip(names, pairs, strict=True)]
        terms = names + list(terms[-1:] if len(terms) % 2 else [])
        lines.append(f"    const real {result}x{level} = {power} * {power};\n")
        power, level = f"{result}x{level}", level + 1
    return "".join(lines) + f"    const real {result} = {terms[0]};\n"


def _turns(double: bool) -> str:
    """Digits of 2/pi as C: in double four parts, of 53 digits each, of 2/pi times 2^(16 i), modulo 2^34.

    2^34 quarter turns times the last digit of an angle are whole turns, and drop out. There are 63 windows, from 2^20
    to the largest double.
    """
    if not double:
        digits = _two_over_pi(224)
        return ", ".join(f"0x{digits >> (224 - 32 * k) & 0xFFFFFFFF:08x}u" for k in range(8))
    digits = _two_over_pi(16 * 63 + 178)
    windows = [digits >> (16 * (63 - window)) & (1 << 212) - 1 for window in range(63)]
    rows = (
        [math.ldexp(float(row >> (159 - 53 * k) & (1 << 53) - 1), -19 - 53 * k) for k in range(4)] for row in windows
    )
    return ",\n    ".join(", ".join(part.hex() for part in row) for row in rows)


def _two_over_pi(bits: int) -> int:
    """2/pi times 2^bits, truncated."""
    one = 1 << bits + 64
    pi = 4 * (4 * _arctan_of_inverse(5, one) - _arctan_of_inverse(239, one))  # Machin
    return 2 * one * one // pi >> 64


def _arctan_of_inverse(n: int, one: int) -> int:
    """arctan(1/n) in units of 1/one."""
    total, power, k = 0, one // n, 0
    while power:
        total += (-1) ** k * (power // (2 * k + 1))
        power, k = power // (n * n), k + 1
    return total
