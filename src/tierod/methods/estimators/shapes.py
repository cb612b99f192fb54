"""The trees that filters of any model share: their sample, their memory, their estimate."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, get_type_hints

from tierod.core.block import Tree, derived, leaves, named_tuple, skeleton
from tierod.core.errors import ParameterError, nearest


class Belief(NamedTuple):
    """Memory of a filter.

    Args:
        mean: the model's State
        covariance: packed upper triangle, row by row
    """

    mean: Any
    covariance: tuple[Any, ...]


def leaf_names(annotation: Any) -> tuple[str, ...]:
    """Dotted names of the leaves that a NamedTuple class declares."""
    return tuple(path for path, _ in leaves(skeleton(annotation)))


def leaf_values(tree: Tree) -> tuple[Any, ...]:
    """The leaves of a tree in order."""
    return tuple(leaf for _, leaf in leaves(tree))


@lru_cache(maxsize=256)
def sample_class(model: type, maskable: tuple[str, ...]) -> type:
    """Sample of a filter: `input`, `measured` and, where states can be masked, `enabled` (0 to 1 for each)."""
    fields = [("input", model.Input), ("measured", model.Output)]  # type: ignore[attr-defined]
    if maskable:
        masks = [(name.replace(".", "_"), Annotated[float, ""]) for name in maskable]
        fields.append(("enabled", named_tuple("Enabled", masks)))
    return named_tuple("Sample", fields)


@lru_cache(maxsize=256)
def estimate_class(model: type, with_covariance: bool) -> type:
    """Output of a filter; `KalmanFilter` says what its fields mean."""
    squared = derived(model.State, "Variance", "({})**2")  # type: ignore[attr-defined]
    innovation = model.Output  # type: ignore[attr-defined]
    number = Annotated[float, ""]
    fields = [
        ("mean", model.State),  # type: ignore[attr-defined]
        ("variance", squared),
        ("innovation", innovation),
        ("innovation_variance", derived(innovation, "InnovationVariance", "({})**2")),
        ("nis", number),
        ("present", number),
    ]
    if with_covariance:
        n = len(leaf_names(model.State))  # type: ignore[attr-defined]
        fields.append(("covariance", tuple[(float,) * (n * (n + 1) // 2)]))  # type: ignore[misc]
    return named_tuple("Estimate", fields)


def class_of_variance(model: type) -> type:
    """The class of the `variance` of an estimate."""
    return get_type_hints(estimate_class(model, False), include_extras=True)["variance"]


def class_of_innovation_variance(model: type) -> type:
    """The class of the `innovation_variance` of an estimate."""
    return get_type_hints(estimate_class(model, False), include_extras=True)["innovation_variance"]


def check_model(model: Any) -> None:
    """Refuse what is not a discrete model.

    Raises:
        ParameterError: equations are missing, or continuous
    """
    if hasattr(model, "transition"):
        return
    name = getattr(model, "__name__", repr(model))
    if hasattr(model, "derivative"):
        raise ParameterError(
            f"{name} is a continuous model and a filter steps in samples; "
            "give tierod.models.discretise.discretise(model, method) instead"
        )
    raise ParameterError(f"{name} has no function `transition`; a filter needs a discrete model")


def check_variances(what: str, values: Any, names: tuple[str, ...], positive: bool = False) -> None:
    """Refuse a tuple of variances of the wrong length or sign.

    Raises:
        ParameterError: not one value per name, or a value below zero or infinite
    """
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"{what} has {len(flat)} values; expected {len(names)}, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if isinstance(value, int) or (isinstance(value, float) and not 0.0 <= value < math.inf):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float that is finite and not negative")
        if positive and (value is None or value == 0.0):
            raise ParameterError(f"{what} of {name} is {value!r}; expected a float greater than zero")


def check_mean(values: Any, names: tuple[str, ...]) -> None:
    """Refuse an initial mean of the wrong length, or one that is not finite.

    Raises:
        ParameterError: not one value per name, or NaN or infinity, which the state would never lose
    """
    flat = leaf_values(values)
    if len(flat) != len(names):
        raise ParameterError(f"initial_mean needs {len(names)} values, one each for {', '.join(names)}")
    for name, value in zip(names, flat, strict=True):
        if not abs(value) < math.inf:
            raise ParameterError(f"initial_mean of {name} is {value!r}; expected a finite number")


def check_names(what: str, given: tuple[str, ...], known: tuple[str, ...]) -> None:
    """Refuse names that are not states.

    Raises:
        ParameterError: with the nearest names
    """
    for name in given:
        if name not in known:
            raise ParameterError(f"{what} names '{name}', which is not a state{nearest(name, known)}")
