"""Blocks: causal discrete-time systems with memory, each written once in ordinary operators.

A block is a frozen dataclass. Its float fields are its tuning and become inputs of the traced graph, so that many
calibrations share one compiled kernel; its other fields (counts, names, flags) are its structure.
States, samples and outputs are trees of NamedTuples and tuples whose leaves are numbers.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache, lru_cache
from numbers import Real
from types import UnionType
from typing import (
    Annotated,
    Any,
    NamedTuple,
    Protocol,
    TypeAlias,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

from typing_extensions import TypeVar  # supports defaults: a bare `Block` is a block of anything

from tierod.core.errors import ParameterError

Scalar: TypeAlias = float  # A number inside a block: a float, or a symbol while the block is traced

# A condition: True or 1.0 where it holds, False or 0.0 where not; a comparison of two `Scalar` gives one
Truth: TypeAlias = bool | float

Tree: TypeAlias = Any  # A scalar, or a (named) tuple of trees

T = TypeVar("T")
State = TypeVar("State", default=Any)
Given = TypeVar("Given", default=Any)
Output = TypeVar("Output", covariant=True, default=Any)


@runtime_checkable
class Block(Protocol[State, Given, Output]):
    """Causal discrete-time system with memory: an estimator, detector, gate, discretised plant or sensor model.

    Its three types are those of the state, of one sample (the class `Sample`) and of the output.

    `step` may take further arguments with defaults (`enabled` of the detectors): they are for composition inside
    another block; drivers of a whole block (scan, stream, batch, generated C) pass the sample only.
    """

    @property
    def Sample(self) -> type[Given]:
        """The NamedTuple class of one sample."""

    def init(self) -> State: ...

    def step(self, state: State, sample: Given, /) -> tuple[State, Output]:
        """Advance by one sample: (state, sample) -> (next state, output)."""


class Ring(NamedTuple):
    """A delay line of `size` samples: the only indexed memory of a block.

    A step reads `oldest` (the value pushed `size` steps ago, `initial` before that) and returns `push(value)` once.
    The size is at least 1.
    """

    size: int
    initial: float = 0.0
    oldest: Scalar = None  # type: ignore[assignment]  # a driver puts it in before every step
    newest: Scalar | None = None

    def push(self, value: Scalar) -> Ring:
        return self._replace(newest=value)


def leaves(tree: Tree, path: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted path, leaf) of every leaf of a tree, in order; a Ring is one leaf."""
    if isinstance(tree, tuple) and not isinstance(tree, Ring):
        names = getattr(tree, "_fields", None) or map(str, range(len(tree)))
        for name, branch in zip(names, tree, strict=True):
            yield from leaves(branch, f"{path}.{name}" if path else name)
    else:
        yield path, tree


def values_of(tree: Tree) -> list[Any]:
    """Every leaf of a tree, in order, without the paths of `leaves`."""
    if not isinstance(tree, tuple) or isinstance(tree, Ring):
        return [tree]
    flat: list[Any] = []
    for branch in tree:
        if isinstance(branch, tuple):
            flat += values_of(branch)
        else:
            flat.append(branch)
    return flat


def rebuild(tree: T, values: Iterable[object]) -> T:
    """A tree of the same shape as `tree` with its leaves taken from `values` in order."""
    source = iter(values)
    return map_leaves(lambda _leaf: next(source), tree)


def map_leaves(function: Callable[[Any], Any], tree: T) -> T:
    """The tree with `function` applied to every leaf."""
    if isinstance(tree, tuple) and not isinstance(tree, Ring):
        branches = [map_leaves(function, branch) for branch in tree]
        kind: Callable[..., T] = type(tree)
        return kind(*branches) if hasattr(tree, "_fields") else kind(branches)
    return function(tree)  # type: ignore[no-any-return]  # a leaf for a leaf


def skeleton(annotation: object) -> Tree:
    """A tree of zeros of the shape that a NamedTuple class or annotation declares."""
    if get_origin(annotation) is Annotated:
        return skeleton(get_args(annotation)[0])
    if get_origin(annotation) is tuple:
        return tuple(skeleton(branch) for branch in get_args(annotation))
    if isinstance(annotation, type) and hasattr(annotation, "_fields"):
        return _zeros(annotation)
    return 0.0


@lru_cache(maxsize=1024)
def _zeros(kind: Any) -> Tree:
    hints = get_type_hints(kind, include_extras=True)
    return kind(*(skeleton(hints[name]) for name in kind._fields))


def units(annotation: object) -> list[str]:
    """The unit of every leaf that a NamedTuple class declares (`Annotated[float, "rad"]`), "" where there is none."""
    if get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        below = units(inner)
        return [str(notes[0])] if len(below) == 1 and below == [""] else below
    if get_origin(annotation) is tuple:
        return [unit for branch in get_args(annotation) for unit in units(branch)]
    if isinstance(annotation, type) and hasattr(annotation, "_fields"):
        hints = get_type_hints(annotation, include_extras=True)
        return [unit for name in annotation._fields for unit in units(hints[name])]
    return [""]


def named_tuple(name: str, fields: Iterable[tuple[str, object]]) -> type:
    """A NamedTuple class made at run time from (field, annotation) pairs; its module is that of the caller."""
    given = tuple(fields)
    made: Any = NamedTuple(name, given)  # type: ignore[misc]  # a name that is known at run time only
    made.__made_by__ = (named_tuple, (name, given))  # type: ignore[attr-defined]
    made.__module__ = sys._getframe(1).f_globals.get("__name__", "__main__")
    return made


def derived(annotation: object, name: str, unit: str) -> Any:
    """A NamedTuple class with the fields of another and its units in a pattern: `derived(State, "Var", "({})**2")`."""
    if get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        return Annotated[inner, unit.format(notes[0] or "1")]
    if get_origin(annotation) is tuple:
        parts = tuple(derived(branch, name, unit) for branch in get_args(annotation))
        return tuple[parts]  # type: ignore[valid-type]  # an annotation made at run time
    if isinstance(annotation, type) and hasattr(annotation, "_fields"):
        hints = get_type_hints(annotation, include_extras=True)
        return named_tuple(name, [(field, derived(hints[field], name, unit)) for field in annotation._fields])
    return annotation


def tuning(block: object, path: str = "") -> Iterator[tuple[str, float]]:
    """(dotted path, value) of every float in a block's fields, nested dataclasses and tuples included.

    An integer in a float field counts as a float: `Cusum(1, 4, 20)` is `Cusum(1.0, 4.0, 20.0)`.
    """
    if isinstance(block, float):
        yield path, block
    else:
        for name, value in _parts(block):
            below = f"{path}.{name}" if path else name
            if type(value) is float:  # almost all; a generator for each costs more than all else here
                yield below, value
            else:
                yield from tuning(value, below)


def with_tuning(block: object, values: Iterable[object]) -> Any:
    """The block with its floats replaced, in the order of `tuning`; used to trace it with symbols."""
    return _with_tuning(block, iter(values))


def _with_tuning(block: object, values: Iterator[object]) -> Any:
    if isinstance(block, float):
        return next(values)
    if dataclasses.is_dataclass(block) and not isinstance(block, type):
        # Not through __init__: the checks of a dataclass compare its floats, and a symbol cannot decide an `if`.
        copy = object.__new__(type(block))
        for name, value in _parts(block):
            object.__setattr__(copy, name, _with_tuning(value, values))
        return copy
    if isinstance(block, tuple):
        parts = [_with_tuning(value, values) for _, value in _parts(block)]
        return type(block)(*parts) if hasattr(block, "_fields") else tuple(parts)
    return block


def structure(block: object) -> object:
    """Parts of a block that decide the shape of its graph: types and every field that is not a float.

    Types are compared by identity: a class that is redefined under the same name is a different one. Each value is
    paired with its type, since True equals 1. An integer in a float field counts as a float.
    """
    if isinstance(block, float):
        return float
    kind: Any = type(block)
    if isinstance(block, tuple) or _fields(kind) is not None:
        return (kind, tuple([float if type(each) is float else structure(each) for _, each in _parts(block)]))
    return (kind, block)


def _parts(block: object) -> Iterable[tuple[str, Any]]:
    """(name, value) of every field of a dataclass or tuple, integers in float fields as floats; else empty."""
    kind: Any = type(block)
    fields = _fields(kind)
    if fields is not None:
        return [(name, _as_meant(getattr(block, name), hint)) for name, hint in fields]
    return zip(map(str, range(len(block))), block, strict=True) if isinstance(block, tuple) else ()


@cache
def _fields(kind: Any) -> tuple[tuple[str, Any], ...] | None:
    """(name, annotation) of every field of a dataclass or NamedTuple; None for any other class."""
    if issubclass(kind, tuple):
        names = getattr(kind, "_fields", None)
    else:
        names = [field.name for field in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else None
    return None if names is None else tuple((name, _hints(kind).get(name)) for name in names)


@cache
def _hints(kind: type) -> dict[str, Any]:
    """Annotations by field; empty where one names a class local to a function: integers then stay integers."""
    try:
        return get_type_hints(kind)
    except NameError:
        return {}


def _as_meant(value: object, hint: object) -> object:
    """A number in a float field, or in a tuple of floats, as a float; any other value unchanged."""
    if type(value) is float or not isinstance(value, tuple | Real):
        return value
    if isinstance(value, tuple) and get_origin(hint) is tuple and not all(type(part) is float for part in value):
        inner = get_args(hint)
        inner = inner[:1] * len(value) if inner[-1:] == (Ellipsis,) else inner
        if len(inner) == len(value):
            return tuple(_as_meant(part, each) for part, each in zip(value, inner, strict=True))
    meant = hint is float or (get_origin(hint) in _UNIONS and float in get_args(hint) and int not in get_args(hint))
    return float(value) if meant and isinstance(value, Real) and not isinstance(value, bool) else value


_UNIONS = (Union, UnionType)


Model: TypeAlias = Any  # The class of a model; the shapes of any model are known only at run time, as those of a `Tree`


def require_discrete(model: Model) -> None:
    if hasattr(model, "transition"):
        return
    name = getattr(model, "__name__", repr(model))
    if hasattr(model, "derivative"):
        raise ParameterError(
            f"{name} is a continuous model and a filter steps in samples; "
            "give tierod.models.linear.discretise(model, method) instead"
        )
    raise ParameterError(f"{name} has no function `transition`; a filter needs a discrete model")


def require_continuous(model: Model) -> None:
    if not hasattr(model, "derivative"):
        raise ParameterError(f"{model.__name__} has no function `derivative`; only a continuous model is discretised")


def model_like(model: Model, name: str, meaning: str, **changed: Any) -> Model:
    """The class of a model with the shapes of another one, where they are not changed, and with its own equations.

    Args:
        model: the other model; its equations are not taken over
    """
    shapes = {part: getattr(model, part) for part in ("State", "Input", "Output", "Parameters")}
    members = {part: value if isinstance(value, type) else staticmethod(value) for part, value in changed.items()}
    return type(name, (), {"__doc__": meaning, "__module__": model.__module__, **shapes, **members})
