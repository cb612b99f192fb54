"""Sample, state and estimate of the filters of any model, checks of their tuning, and parameters as states."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, get_type_hints

from tierod.core.block import (
    Model,
    Scalar,
    Tree,
    derived,
    leaves,
    model_like,
    named_tuple,
    rebuild,
    skeleton,
    values_of,
)
from tierod.core.errors import ParameterError, nearest


class Belief(NamedTuple):
    """State of a filter: mean and covariance of the estimate."""

    mean: Tree  # the model's State
    covariance: tuple[Scalar, ...]  # packed upper triangle, row by row


def leaf_names(annotation: type) -> tuple[str, ...]:
    """Dotted names of the leaves that a NamedTuple class declares."""
    return tuple(path for path, _ in leaves(skeleton(annotation)))


def leaf_values(tree: Tree) -> tuple[Scalar, ...]:
    """The leaves of a tree in order, as a flat tuple."""
    return tuple(values_of(tree))


def filled(shape: type, *parts: Iterable[Scalar]) -> Tree:
    """The tree that a NamedTuple class declares, filled with the leaves of flat parts in order."""
    return rebuild(skeleton(shape), itertools.chain(*parts))


@lru_cache(maxsize=256)
def sample_class(model: Model, maskable: tuple[str, ...]) -> type:
    """Class of a filter's sample: `input`, `measured` and, where states can be masked, `enabled` (0 to 1 for each)."""
    fields = [("input", model.Input), ("measured", model.Output)]
    if maskable:
        masks = [(name.replace(".", "_"), Annotated[float, ""]) for name in maskable]
        fields.append(("enabled", named_tuple("Enabled", masks)))
    return named_tuple("Sample", fields)


@lru_cache(maxsize=256)
def estimate_class(model: Model, with_covariance: bool) -> type:
    """Class of a filter's output; `KalmanFilter` explains the fields."""
    squared = derived(model.State, "Variance", "({})**2")
    innovation = model.Output
    number = Annotated[float, ""]
    fields = [
        ("mean", model.State),
        ("variance", squared),
        ("innovation", innovation),
        ("innovation_variance", derived(innovation, "InnovationVariance", "({})**2")),
        ("nis", number),
        ("present", number),
    ]
    if with_covariance:
        n = len(leaf_names(model.State))
        fields.append(("covariance", tuple[(float,) * (n * (n + 1) // 2)]))  # type: ignore[misc]
    return named_tuple("Estimate", fields)


def check_variances(what: str, values: Tree, names: tuple[str, ...], positive: bool = False) -> None:
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"{what} has {len(flat)} values; expected {len(names)}, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if isinstance(value, int) or (isinstance(value, float) and not 0.0 <= value < math.inf):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float that is finite and not negative")
        if positive and (value is None or value == 0.0):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float greater than zero")


def check_mean(values: Tree, names: tuple[str, ...]) -> None:
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"initial_mean needs {len(names)} values, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if not abs(value) < math.inf:
            raise ParameterError(f"initial_mean of {name} is {value!r}; expected a finite number")


def check_names(what: str, given: tuple[str, ...], known: tuple[str, ...]) -> None:
    for name in given:
        if name not in known:
            raise ParameterError(f"{what} names '{name}', which is not a state{nearest(name, known)}")


@lru_cache(maxsize=256)
def augment(model: Model, *parameters: str) -> Model:
    """A model whose state holds the named parameters too, as constants that process noise turns into random walks.

    Returns:
        a model of the same kind: the same Input, Output and Parameters, and a State with the parameters at its end,
            in
        their units. The values of these parameters in `Parameters` are no longer used
    """
    base_hints = get_type_hints(model.State, include_extras=True)
    fields = [(name, base_hints[name]) for name in model.State._fields]
    for path in parameters:
        name = path.replace(".", "_")
        if name in dict(fields):
            raise ParameterError(f"{model.__name__} has a state '{name}' already; it cannot be augmented with it again")
        fields.append((name, _annotation(model.Parameters, path)))
    if len(fields) == len(base_hints):
        raise ParameterError("augment needs at least one name of a parameter to turn into a state")
    made = _make(model, parameters, named_tuple("State", fields))
    made.__made_by__ = (augment, (model, *parameters))
    return made


def _make(model: Model, parameters: tuple[str, ...], state_class: type) -> Model:
    count = len(model.State._fields)

    def split(x: Tree, p: Tree) -> tuple[Tree, Tree, tuple[Scalar, ...]]:
        estimated = tuple(x[count:])
        for path, value in zip(parameters, estimated, strict=True):
            p = _with(p, path, value)
        return model.State(*x[:count]), p, estimated

    def output(x: Tree, u: Tree, p: Tree) -> Tree:
        base, p, _ = split(x, p)
        return model.output(base, u, p)

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        base, p, estimated = split(x, p)
        return state_class(*model.transition(base, u, p), *estimated)

    def derivative(x: Tree, u: Tree, p: Tree) -> Tree:
        base, p, estimated = split(x, p)
        return state_class(*model.derivative(base, u, p), *(0.0 for _ in estimated))

    equation = transition if hasattr(model, "transition") else derivative
    return model_like(
        model,
        f"{model.__name__}With{''.join(_title(path) for path in parameters)}",
        f"{model.__name__} with {', '.join(parameters)} as states.",
        State=state_class,
        output=output,
        **{equation.__name__: equation},
    )


def _title(path: str) -> str:
    return "".join(word.capitalize() for word in path.replace(".", "_").split("_"))


def _annotation(parameters: Any, path: str) -> Any:
    first, _, rest = path.partition(".")
    hints = get_type_hints(parameters, include_extras=True)
    known = [field.name for field in dataclasses.fields(parameters)]
    if first not in known:
        raise ParameterError(f"'{path}' is not a parameter of {parameters.__qualname__}{nearest(first, known)}")
    annotation = hints[first]
    if rest:
        if not dataclasses.is_dataclass(annotation):
            raise ParameterError(
                f"'{first}' of {parameters.__qualname__} has no part '{rest}'; it is a single parameter"
            )
        return _annotation(annotation, rest)
    if getattr(annotation, "__origin__", annotation) is not float:
        raise ParameterError(f"'{path}' of {parameters.__qualname__} is not a float, so it cannot become a state")
    return annotation


def _with(p: Tree, path: str, value: Scalar) -> Tree:
    first, _, rest = path.partition(".")
    changed = copy.copy(p)
    object.__setattr__(changed, first, _with(getattr(p, first), rest, value) if rest else value)
    return changed
