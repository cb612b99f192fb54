"""Mathematical helper functions of an export, taken from the kernels' C code; only those that are called."""

from __future__ import annotations

import re

from tierod.core.graph.c_functions import definitions
from tierod.export.spelling import Spelling

_OF_TWO = ("atan2", "pow", "hypot")

_OF_ONE = frozenset(
    ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "expm1", "log", "log1p"]
)
"""C library functions for which the kernels may have implementations of their own."""

_BEGINNING = re.compile(r"^(?=/\* |TIEROD_INLINE |typedef |#define |static const )", re.MULTILINE)
_NAME = re.compile(r"\b(?:tierod|TIEROD)_\w+")
_DEFINED = re.compile(r"^(?:TIEROD_INLINE \w+|typedef \w+|#define|static const \w+) (\w+)", re.MULTILINE)


def helpers(spelling: Spelling, text: str, libm: bool = True) -> str:
    """C code of the helper functions that a piece of C code calls.

    Args:
        libm: whether functions such as the sine come from the C library rather than from the kernels
    """
    wanted = sorted(set(re.findall(rf"\b{spelling.prefix}_(\w+)\(", text)))
    if libm:
        return "".join(f"{spelling.literals(made)}\n" for name in wanted if (made := _helper(spelling, name)))
    own = [name for name in wanted if name in _OF_ONE or name in _OF_TWO]
    functions = _renamed(spelling, _reached(definitions(own, spelling.precision == "single"), own))
    basic = [name for name in ("fma", "sign") if f"{spelling.prefix}_{name}(" in text + functions]
    return "".join(f"{spelling.literals(_helper(spelling, name))}\n" for name in basic) + functions


def _reached(text: str, wanted: list[str]) -> str:
    parts: list[str] = []
    for part in _BEGINNING.split(text):
        # A comment belongs to the definition that follows it.
        if parts and parts[-1].startswith("/*") and parts[-1].rstrip().endswith("*/"):
            parts[-1] += part
        else:
            parts.append(part)
    named = {found[1]: part for part in parts if (found := _DEFINED.search(part))}
    waiting, needed = [f"tierod_{name}" for name in wanted], set()
    while waiting:
        name = waiting.pop()
        if name in named and name not in needed:
            needed.add(name)
            waiting += _NAME.findall(named[name])
    return "".join(f"{part.rstrip()}\n\n" for part in parts if (f := _DEFINED.search(part)) and f[1] in needed)


def _renamed(spelling: Spelling, text: str) -> str:
    text = text.replace("#ifdef TIEROD_FAST_FMA", f"#if {_fast(spelling)}").replace("TIEROD_INLINE ", "static ")
    text = re.sub(r"\bTIEROD_(\w+)", lambda found: f"{spelling.prefix.upper()}_{found[1]}", text)
    text = re.sub(r"\btierod_(\w+)", lambda found: f"{spelling.prefix}_{found[1]}", text)
    return spelling.literals(re.sub(r"\breal\b", spelling.real, text))


def _fast(spelling: Spelling) -> str:
    """C condition that the target has a fused multiply-add; newlib does not define the macro of the C standard."""
    name = "FP_FAST_FMA" if spelling.precision == "double" else "FP_FAST_FMAF"
    return f"defined {name} || defined __{name}"


def _helper(spelling: Spelling, name: str) -> str:
    """C code of a helper function; "" for an unknown name."""
    prefix, real = spelling.prefix, spelling.real
    if name == "fma":
        plain = f"#if {_fast(spelling)}\n    return M(fma)(a, b, c);\n#else\n    return (a * b) + c;\n#endif\n"
        body = "    return M(fma)(a, b, c);\n" if spelling.fused else plain
        return f"static {real} {prefix}_fma({real} a, {real} b, {real} c)\n{{\n{body}}}\n"
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
