"""Augmented models: with parameters as states that a filter estimates too, or with past states."""

from __future__ import annotations

import copy
import dataclasses
from functools import lru_cache
from typing import Any, get_type_hints

from tierod.core.block import Model, Scalar, Tree, model_like, named_tuple
from tierod.core.errors import ParameterError, nearest


@lru_cache(maxsize=256)
def augment(model: Model, *parameters: str) -> Model:
    """A model whose state holds the named parameters too, as constants that process noise turns into random walks.

    Args:
        parameters: names of fields of `model.Parameters`, dotted where they lie in a nested dataclass
            (`"tyre.stiffness"` becomes the state `tyre_stiffness`)

    Returns:
        a model of the same kind: the same Input, Output and Parameters, and a State with the parameters at its end, in
        their units. The values of these parameters in `Parameters` are no longer used

    Raises:
        ParameterError: no parameter given, no such parameter, one that is not a float, or a state of that name exists
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
    return _make(model, parameters, named_tuple("State", fields))


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
