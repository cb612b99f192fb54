"""Sample, state and estimate of the filters of any model, as NamedTuple classes, and checks of their tuning."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Model, Scalar, Tree, derived, leaves, named_tuple, rebuild, skeleton, values_of
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
    """Check length and values of a tuple of variances.

    Raises:
        ParameterError: not one value per name, or a value that is no float, negative, infinite, or zero or None where
            it must be positive
    """
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"{what} has {len(flat)} values; expected {len(names)}, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if isinstance(value, int) or (isinstance(value, float) and not 0.0 <= value < math.inf):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float that is finite and not negative")
        if positive and (value is None or value == 0.0):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float greater than zero")


def check_mean(values: Tree, names: tuple[str, ...]) -> None:
    """Check length and values of an initial mean.

    Raises:
        ParameterError: not one value per name, or NaN or infinity, which would stay in the state for ever
    """
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"initial_mean needs {len(names)} values, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if not abs(value) < math.inf:
            raise ParameterError(f"initial_mean of {name} is {value!r}; expected a finite number")


def check_names(what: str, given: tuple[str, ...], known: tuple[str, ...]) -> None:
    """Check that given names are names of states.

    Raises:
        ParameterError: another name; the nearest names are proposed
    """
    for name in given:
        if name not in known:
            raise ParameterError(f"{what} names '{name}', which is not a state{nearest(name, known)}")
