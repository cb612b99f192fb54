"""Functions that the kernels' C has of its own, as functions of an export; only those that it calls."""

from __future__ import annotations

import re

from tierod.export.spelling import Spelling

_OF_TWO = ("atan2", "pow", "hypot")


def helpers(spelling: Spelling, text: str) -> str:
    """The helpers that a text calls.

    Args:
        spelling: of names and numbers
        text: C
    """
    wanted = sorted(set(re.findall(rf"\b{spelling.prefix}_(\w+)\(", text)))
    return "".join(f"{spelling.literals(made)}\n" for name in wanted if (made := _helper(spelling, name)))


def _helper(spelling: Spelling, name: str) -> str:
    """C of a helper; "" for what is none."""
    prefix, real = spelling.prefix, spelling.real
    if name == "fma":
        fast = "FP_FAST_FMA" if spelling.precision == "double" else "FP_FAST_FMAF"
        return (
            f"static {real} {prefix}_fma({real} a, {real} b, {real} c)\n{{\n#ifdef {fast}\n"
            f"    return M(fma)(a, b, c);\n#else\n    return (a * b) + c;\n#endif\n}}\n"
        )
    if name == "sign":
        return (
            f"static {real} {prefix}_sign({real} a)\n{{\n"
            f"    return (a > R(0.0)) ? R(1.0) : ((a < R(0.0)) ? -R(1.0) : a);\n}}\n"
        )
    if name in _OF_TWO:
        return f"static {real} {prefix}_{name}({real} a, {real} b)\n{{\n    return M({name})(a, b);\n}}\n"
    if name in _OF_ONE:
        return f"static {real} {prefix}_{name}({real} a)\n{{\n    return M({name})(a);\n}}\n"
    return ""


_OF_ONE = frozenset(
    ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "expm1", "log", "log1p"]
)
"""Functions of the C library that the kernels may have of their own."""
