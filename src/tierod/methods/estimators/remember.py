"""Models that remember some of their states for a while, so that any filter smooths them over a fixed lag."""

from __future__ import annotations

from functools import lru_cache
from typing import get_type_hints

from tierod.core.block import Tree, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.model import Model, model_like, require_discrete


@lru_cache(maxsize=64)
def remember(model: Model, lag: int, *states: str) -> Model:
    """A model whose state also holds what some of its states were, sample by sample back to the lag.

    A filter of it, extended, unscented or one of a bank, estimates the states of the past from all measurements until
    now: a fixed-lag smoother. The covariance grows by `lag` rows for each of them; where the gain is stationary,
    `FixedLag` does the same at a fraction of the cost.

    Args:
        model: discrete
        lag: samples, at least 1
        states: names of top-level states

    Returns:
        a discrete model with the same Input, Output and Parameters, and a State with `NAME_1_ago` to `NAME_{lag}_ago`
        at its end; give them no process noise

    Raises:
        ParameterError: a continuous model, no lag, or no such state

    Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, 1979, section 7.3.
    """
    require_discrete(model)
    known = model.State._fields
    if lag < 1:
        raise ParameterError(f"lag is {lag}; expected at least 1 sample")
    if not states:
        raise ParameterError(f"remember needs at least one name of a state ({', '.join(known)})")
    for name in states:
        if name not in known:
            raise ParameterError(f"{model.__name__} has no state '{name}'{nearest(name, known)}")
    hints = get_type_hints(model.State, include_extras=True)
    fields = [(name, hints[name]) for name in known]
    fields += [(f"{name}_{k}_ago", hints[name]) for name in states for k in range(1, lag + 1)]
    return _make(model, lag, states, named_tuple("State", fields))


def _make(model: Model, lag: int, states: tuple[str, ...], state_class: type) -> Model:
    count = len(model.State._fields)

    def present(x: Tree) -> Tree:
        return model.State(*x[:count])

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        past = []
        for k, name in enumerate(states):
            start = count + k * lag
            past += [getattr(x, name), *x[start : start + lag - 1]]
        return state_class(*model.transition(present(x), u, p), *past)

    def output(x: Tree, u: Tree, p: Tree) -> Tree:
        return model.output(present(x), u, p)

    return model_like(
        model,
        f"{model.__name__}Remembering",
        f"{model.__name__}, remembering {', '.join(states)} for {lag} samples.",
        State=state_class,
        transition=transition,
        output=output,
    )
