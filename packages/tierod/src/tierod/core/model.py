"""Models: equations without memory.

A model is a class without state of its own: `State`, `Input`, `Output` are NamedTuples, `Parameters` a frozen
dataclass, and its two functions are pure: `output(x, u, p)` gives the measurements; `derivative(x, u, p)` of a
continuous model gives the derivative of the state, `transition(x, u, p)` of a discrete one the state one sample later.
Noise belongs to the estimator that uses the model, not to the model. `tests/contract/test_models.py` checks this for
every model of the package.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from tierod.core.errors import ParameterError

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
