"""The functions that models and blocks may use, for floats, NumPy arrays and traced symbols alike.

Logic is 0.0 or 1.0. `where` selects, it never multiplies, so NaN in the branch not taken does no harm.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypeVar

from tierod.core.block import Scalar, T, Truth, rebuild, values_of

Array: TypeAlias = NDArray[np.float64]

# A scalar, or an array of them: for formulas that serve blocks and whole recordings alike
Number = TypeVar("Number", Scalar, Array, default=Scalar)


class OfOne(Protocol):
    """Function of one scalar, or of an array element by element."""

    @overload
    def __call__(self, value: Scalar, /) -> Scalar: ...
    @overload
    def __call__(self, value: Array, /) -> Array: ...


class OfTwo(Protocol):
    """Function of two scalars, or of arrays element by element."""

    @overload
    def __call__(self, a: Scalar, b: Scalar, /) -> Scalar: ...
    @overload
    def __call__(self, a: Array, b: Scalar | Array, /) -> Array: ...
    @overload
    def __call__(self, a: Scalar, b: Array, /) -> Array: ...


class Where(Protocol):
    """Selection by a condition, of arrays element by element."""

    @overload
    def __call__(self, condition: Truth, a: Scalar, b: Scalar, /) -> Scalar: ...
    @overload
    def __call__(self, condition: np.ndarray, a: Scalar | Array, b: Scalar | Array, /) -> Array: ...
    @overload
    def __call__(self, condition: Truth, a: Array, b: Scalar | Array, /) -> Array: ...
    @overload
    def __call__(self, condition: Truth, a: Scalar, b: Array, /) -> Array: ...


def is_symbol(value: object) -> bool:
    """Whether a value is a symbol of a running trace."""
    # Not imported here: as long as CasADi is not loaded, there can be no symbol.
    casadi = sys.modules.get("casadi")
    return casadi is not None and isinstance(value, casadi.SX)


def _dispatch(name: str, plain: Callable[..., Any], array: Callable[..., Any], symbolic: str, meaning: str) -> Any:
    def function(*args: Any) -> Any:
        for value in args:
            if is_symbol(value):
                return getattr(sys.modules["casadi"], symbolic)(*args)
        if any(isinstance(value, np.ndarray) for value in args):
            return array(*args)
        return plain(*args)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"{meaning}."
    return function


def _guarded(plain: Callable[..., float]) -> Callable[..., float]:
    """A function with IEEE results instead of Python's exceptions, so that floats and kernels agree."""

    def function(*args: float) -> float:
        try:
            return plain(*args)
        except (ValueError, OverflowError):
            with np.errstate(all="ignore"):
                return float(getattr(np, plain.__name__)(*args))

    return function


def _quiet(function: Callable[..., Any]) -> Callable[..., float]:
    def quiet(*args: float) -> float:
        with np.errstate(all="ignore"):
            return float(function(*map(float, args)))

    return quiet


def _sign(x: float) -> float:
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else x * 0.0  # keeps NaN and the sign of zero


sin: OfOne = _dispatch("sin", _guarded(math.sin), np.sin, "sin", "Sine of an angle [rad]")
cos: OfOne = _dispatch("cos", _guarded(math.cos), np.cos, "cos", "Cosine of an angle [rad]")
tan: OfOne = _dispatch("tan", _guarded(math.tan), np.tan, "tan", "Tangent of an angle [rad]")
arctan: OfOne = _dispatch("arctan", math.atan, np.arctan, "atan", "Inverse tangent [rad]")
arcsin: OfOne = _dispatch("arcsin", _quiet(np.arcsin), np.arcsin, "asin", "Inverse sine [rad]")
arctan2: OfTwo = _dispatch(
    "arctan2", math.atan2, np.arctan2, "atan2", "Angle of the point (x, y), arguments y, x [rad]"
)
tanh: OfOne = _dispatch("tanh", math.tanh, np.tanh, "tanh", "Hyperbolic tangent")
exp: OfOne = _dispatch("exp", _guarded(math.exp), np.exp, "exp", "Exponential function")
expm1: OfOne = _dispatch("expm1", _guarded(math.expm1), np.expm1, "expm1", "exp(x) - 1 without cancellation")
log: OfOne = _dispatch(
    "log",
    lambda x: math.log(x) if x > 0.0 else (-math.inf if x == 0.0 else math.nan),
    np.log,
    "log",
    "Natural logarithm",
)
sqrt: OfOne = _dispatch("sqrt", lambda x: math.sqrt(x) if x >= 0.0 else math.nan, np.sqrt, "sqrt", "Square root")
hypot: OfTwo = _dispatch("hypot", math.hypot, np.hypot, "hypot", "Length of the vector (a, b)")
sign: OfOne = _dispatch("sign", _sign, np.sign, "sign", "-1, 0 or 1 (NaN stays NaN)")
absolute: OfOne = _dispatch("absolute", abs, np.abs, "fabs", "Absolute value")
floor: OfOne = _dispatch(
    "floor",
    lambda x: float(math.floor(x)) if math.isfinite(x) else x,
    np.floor,
    "floor",
    "Largest whole number not above",
)
power: OfTwo = _dispatch(
    "power", _quiet(np.power), np.power, "power", "base ** exponent; NaN for a negative base and a broken exponent"
)
both: Callable[[Truth, Truth], Truth] = _dispatch(
    "both", lambda a, b: float(bool(a) and bool(b)), np.logical_and, "logic_and", "Whether a and b"
)
either: Callable[[Truth, Truth], Truth] = _dispatch(
    "either", lambda a, b: float(bool(a) or bool(b)), np.logical_or, "logic_or", "Whether a or b"
)
negated: Callable[[Truth], Truth] = _dispatch(
    "negated", lambda a: float(not a), np.logical_not, "logic_not", "Whether not a"
)
where: Where = _dispatch(
    "where", lambda c, a, b: a if c else b, np.where, "if_else", "a where the condition holds, else b"
)


def minimum(a: Number, b: Number | Scalar) -> Number:
    """The smaller of two; the first where one is NaN (the same in every driver, unlike fmin of C)."""
    return where(b < a, b, a)


def maximum(a: Number, b: Number | Scalar) -> Number:
    """The larger of two; the first where one is NaN (the same in every driver, unlike fmax of C)."""
    return where(a < b, b, a)


def greatest_of(first: Scalar, *others: Scalar) -> Scalar:
    """The largest of several."""
    for other in others:
        first = maximum(first, other)
    return first


def all_of(first: Truth, *others: Truth) -> Truth:
    """Whether every condition holds."""
    for other in others:
        first = both(first, other)
    return first


def any_of(first: Truth, *others: Truth) -> Truth:
    """Whether at least one condition holds."""
    for other in others:
        first = either(first, other)
    return first


def select(condition: Truth, taken: T, otherwise: T) -> T:
    """One of two trees of the same shape, leaf by leaf: the first where the condition holds, else the second."""
    pairs = zip(values_of(taken), values_of(otherwise), strict=True)
    return rebuild(otherwise, [where(condition, a, b) for a, b in pairs])


def present(value: Scalar) -> Truth:
    """Whether a measurement is present: finite, not NaN."""
    return absolute(value) < math.inf


def limit(value: Number, lower: Number | Scalar, upper: Number | Scalar) -> Number:
    return minimum(maximum(value, lower), upper)
