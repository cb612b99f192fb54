"""Fixed-step integration of a plant's equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from tierod.block import leaves, rebuild

State = TypeVar("State", bound=tuple)


def runge_kutta(derivative: Callable[[State], State], state: State, step: Any) -> State:
    """The state one step on, by the classical Runge-Kutta method of fourth order.

    Args:
        derivative: rate of change of a state, in the state's own shape
        state: tree of numbers
        step: [s]; stable while step times the fastest rate stays below about 2.7
    """
    first = derivative(state)
    second = derivative(_ahead(state, first, 0.5 * step))
    third = derivative(_ahead(state, second, 0.5 * step))
    fourth = derivative(_ahead(state, third, step))
    slopes = zip(*(map(_leaf, leaves(slope)) for slope in (first, second, third, fourth)), strict=True)
    mean = [(a + 2.0 * (b + c) + d) / 6.0 for a, b, c, d in slopes]
    return _ahead(state, rebuild(state, mean), step)


def _ahead(state: State, slope: State, step: Any) -> State:
    return rebuild(state, [x + step * rate for (_, x), (_, rate) in zip(leaves(state), leaves(slope), strict=True)])


def _leaf(named: tuple[str, Any]) -> Any:
    return named[1]
