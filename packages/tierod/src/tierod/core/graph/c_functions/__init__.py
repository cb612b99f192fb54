"""The C that every kernel begins with: one real type, and tierod's own mathematical functions.

Only square root, absolute value and rounding, which are instructions, are taken from the C library. The functions have
no branch, so that a loop over lanes vectorises where they occur, and are the same in every driver. Their error is at
most two units in the last place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from tierod.core.graph.c_functions.circular import arctangent, sine_and_cosine
from tierod.core.graph.c_functions.exponential import exponential, length, logarithm, power
from tierod.core.graph.c_functions.number import (
    ALWAYS_INLINE,
    DOUBLE,
    FLOAT,
    FUSED,
    HEAD,
    INLINE,
    SIGN,
    Real,
    bits,
    exact,
)
from tierod.core.graph.c_functions.reduction import reduction

__all__ = ["FUSED", "OWN", "definitions", "prelude"]

_PARTS: dict[str, tuple[Callable[[Real], str], ...]] = {
    "circular": (bits, exact, reduction, sine_and_cosine),
    "arctangent": (bits, exact, arctangent),
    "exponential": (bits, exact, exponential),
    "logarithm": (bits, exact, logarithm),
    "power": (bits, exact, exponential, logarithm, power),
    "length": (length,),
}
"""C that each group of functions needs, in order."""

_GROUPS = {
    **dict.fromkeys(("sin", "cos", "tan"), "circular"),
    **dict.fromkeys(("asin", "acos", "atan", "atan2"), "arctangent"),
    **dict.fromkeys(("exp", "expm1", "sinh", "cosh", "tanh"), "exponential"),
    **dict.fromkeys(("log", "log1p"), "logarithm"),
    "pow": "power",
    "hypot": "length",
}

OWN = {name: f"tierod_{name}" for name in ("sign", *_GROUPS)}
"""Names of tierod's own C functions, by the name of the operation."""


def prelude(operations: Iterable[str], in_lanes: bool = False) -> str:
    """Head of a kernel: types, and the functions that the kernel uses, in double and in float.

    Args:
        operations: names of the operations that are printed
        in_lanes: whether a loop that must vectorise uses them
    """
    ordered = _ordered(operations)
    head = HEAD + (ALWAYS_INLINE if in_lanes else "") + INLINE + SIGN
    if not ordered:
        return head
    texts = ["".join(part(real) for part in ordered) for real in (FLOAT, DOUBLE)]
    return f"{head}#ifdef TIEROD_FLOAT32\n{texts[0]}#else\n{texts[1]}#endif\n"


def definitions(operations: Iterable[str], single: bool) -> str:
    """The functions alone, in one precision; `tierod_fma`, which multiplies and adds, is left to the caller.

    Args:
        operations: names of the operations that are printed
        single: whether in float, else in double
    """
    return "".join(part(FLOAT if single else DOUBLE) for part in _ordered(operations))


def _ordered(operations: Iterable[str]) -> list[Callable[[Real], str]]:
    groups = {_GROUPS[name] for name in operations if name in _GROUPS}
    wanted = {part for group in groups for part in _PARTS[group]}
    return list(dict.fromkeys(part for parts in _PARTS.values() for part in parts if part in wanted))
