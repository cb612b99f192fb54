"""The functions that kernels do not take from the C library, against arithmetic of 400 bits."""

import ctypes
import itertools
import math
from functools import cache

import numpy as np
import pytest

from tierod.core.graph.c_functions import OWN, prelude
from tierod.core.graph.compiler import compiler, load

needs_a_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")

OF_TWO = ("atan2", "pow", "hypot")
KINDS = {
    "double": ("", np.float64),
    "double without fused operations": ("#include <math.h>\n#undef FP_FAST_FMA\n", np.float64),
    "float": ("#define TIEROD_FLOAT32\n", np.float32),
}
RANDOM = np.random.default_rng(5)
COUNT = 200  # Arguments of each function, kind and range: mpmath takes some 50 us each


@cache
def library(kind):
    source = KINDS[kind][0] + prelude(OWN)
    for name, function in OWN.items():
        arguments = "a[i], b[i]" if name in OF_TWO else "a[i]"
        signature = f"void all_{name}(long n, const real *a, const real *b, real *y)"
        loop = f"for (long i = 0; i < n; i++) y[i] = {function}({arguments});"
        source += f"{signature};\n{signature} {{ (void)b; {loop} }}\n"
    return load(source, "own_functions")


def values(kind, name, first, second=None):
    number = KINDS[kind][1]
    a, b = (np.ascontiguousarray(each, number) for each in (first, first if second is None else second))
    y = np.empty_like(a)
    function = getattr(library(kind), f"all_{name}")
    function.argtypes = (ctypes.c_long, *[ctypes.c_void_p] * 3)
    function(len(a), a.ctypes.data, b.ctypes.data, y.ctypes.data)
    return y


def powers(low, high):
    """Numbers of all sizes from 2^low to 2^high, of both signs."""
    return RANDOM.choice([-1.0, 1.0], COUNT) * np.exp2(RANDOM.uniform(low, high, COUNT))


def between(low, high):
    return RANDOM.uniform(low, high, COUNT)


def arguments(name, number):
    """What each function is asked: usual arguments, all sizes, subnormal ones, and those where others fail."""
    info = np.finfo(number)
    least, most = info.minexp - info.nmant, info.maxexp - 1
    every = powers(least, most)
    turns = np.round(np.abs(powers(0, 40))) * np.pi / 2.0
    longest = math.log(float(info.max))
    exponents = (between(-longest - 40.0, longest), between(-1.5, 1.5), between(-5.0, 5.0), powers(least, 0))
    near_one = 1.0 + powers(-info.nmant, -1)
    single = {
        **dict.fromkeys(("sin", "cos", "tan"), (every, between(-10.0, 10.0), between(-1e6, 1e6), turns)),
        **dict.fromkeys(("asin", "acos"), (between(-1.0, 1.0), powers(least, 0))),
        "atan": [every, between(-3.0, 3.0)],
        **dict.fromkeys(("exp", "expm1", "sinh", "cosh", "tanh"), exponents),
        "log": [np.abs(every), between(0.5, 2.0), near_one],
        "log1p": [np.abs(every), between(-0.99, 2.0), powers(least, -1)],
    }
    if name in single:
        return [(each, each) for each in single[name]]
    if name != "pow":
        return [(every, RANDOM.permutation(every)), (between(-1.0, 1.0), between(-1.0, 1.0))]
    bases = np.abs(every)
    reach = (most + 40.0) / np.maximum(np.abs(np.log2(bases)), 1e-9)
    close = most / np.maximum(np.abs(np.log2(near_one)), 1e-9)
    whole = (between(-9.0, 0.0), np.round(between(-30.0, 30.0)))
    return [(bases, between(-1, 1) * reach), (near_one, between(-1, 1) * close), (between(0, 5), between(-3, 3)), whole]


def units_in_the_last_place(found, exact, number, mp):
    """Errors of finite results; a result that is infinite must be too large for the type."""
    info = np.finfo(number)
    errors = []
    for value, right in zip(found.tolist(), exact, strict=True):
        if not math.isfinite(value):
            errors.append(0.0 if abs(right) > float(info.max) else math.inf)
        elif right == 0:
            errors.append(0.0 if value == 0.0 else math.inf)
        else:
            unit = mp.mpf(2) ** (max(int(mp.floor(mp.log(abs(right), 2))), info.minexp) - info.nmant)
            errors.append(float(abs(mp.mpf(value) - right) / unit))
    return np.array(errors)


@needs_a_compiler
@pytest.mark.parametrize("name", [name for name in OWN if name != "sign"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_error_is_at_most_two_units_in_the_last_place(kind, name):
    mp = pytest.importorskip("mpmath", reason="the digits come from mpmath")
    number = KINDS[kind][1]
    function = getattr(mp, {"pow": "power"}.get(name, name))
    with mp.workprec(400):
        for a, b in arguments(name, number):
            with np.errstate(over="ignore"):
                a, b = a.astype(number), b.astype(number)
            fits = np.isfinite(a) & np.isfinite(b)
            a, b = a[fits], b[fits]
            pairs = zip(map(mp.mpf, a.tolist()), map(mp.mpf, b.tolist()), strict=True)
            exact = [function(x, y) if name in OF_TWO else function(x) for x, y in pairs]
            errors = units_in_the_last_place(values(kind, name, a, b), exact, number, mp)
            worst = int(np.argmax(errors))
            assert errors[worst] <= 2.0, (a[worst], b[worst])


def same(found, right):
    """Equal to two units, with the same sign of zero, and NaN where it belongs."""
    close = np.abs(found - right) <= 2.0 * np.spacing(np.abs(right))
    alike = np.signbit(found) == np.signbit(right)
    return (np.isnan(found) & np.isnan(right)) | (((found == right) | close) & alike)


@needs_a_compiler
@pytest.mark.parametrize("name", [name for name in OWN if name != "sign"])
@pytest.mark.parametrize("kind", KINDS)
def test_special_numbers_give_what_the_standard_says(kind, name):
    number = KINDS[kind][1]
    info = np.finfo(number)
    sizes = [0.0, float(info.smallest_subnormal), float(info.tiny), 0.5, 1.0, 2.0, 2.5, 3.0, float(info.max), np.inf]
    special = [sign * size for size in sizes for sign in (1.0, -1.0)] + [np.nan]
    pairs = np.array(list(itertools.product(special, special)), number).T
    a, b = pairs if name in OF_TWO else (np.array(special, number),) * 2
    names = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}
    reference = getattr(np, names.get(name, name))
    with np.errstate(all="ignore"):
        wide = [each.astype(np.float64) for each in (a, b)]
        right = (reference(*wide) if name in OF_TWO else reference(wide[0])).astype(number)
        found = values(kind, name, a, b)
        assert same(found, right).all(), [(a[i], b[i], found[i], right[i]) for i in np.flatnonzero(~same(found, right))]
