"""The least spread that any unbiased estimate of parameters can have, from a model driven by known inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tierod.core.block import Tree, leaves, skeleton
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph import scan
from tierod.methods.analysis.cramer_rao import Bound, bound
from tierod.methods.estimators.augment import augment
from tierod.methods.identification.simulation import Simulation


def parameter_bound(
    model: Any,
    parameters: Any,
    initial: Tree,
    inputs: np.ndarray,
    noise: Mapping[str, float],
    free: Sequence[str],
    free_states: Sequence[str] = (),
) -> Bound:
    """The bound for parameters, and for entries of the first state, of any discrete model (Cramer and Rao).

    The sensitivities are exact derivatives along the simulated run; nothing but the sensors' noise disturbs it. Where
    the bound is infinite, this test tells nothing of that parameter, whatever estimates it.

    Args:
        model: discrete, such as one made by `discretise`
        parameters: of the model, at which the bound is taken
        initial: first state
        inputs: of every sample, in the order of `model.Input`, (samples, inputs)
        noise: standard deviation of every output that is measured, white from sample to sample, by name; outputs that
            are not named are not measured
        free: names of the parameters that are unknown, dotted where they lie in a nested dataclass
        free_states: names of entries of the first state that are unknown too

    Raises:
        ParameterError: no such output, parameter or state, or a noise that is not above zero
    """
    states, outputs = _names(model.State), _names(model.Output)
    _require_known(noise, outputs, "output")
    _require_known(free_states, states, "state")
    wrong = [name for name, deviation in noise.items() if not 0.0 < deviation < np.inf]
    if wrong or not noise:
        raise ParameterError(f"no noise above zero is given for {', '.join(wrong) or 'any output'}")
    larger = augment(model, *free) if free else model
    start = [float(leaf) for _, leaf in leaves(initial)] + [_value(parameters, path) for path in free]
    places = (*range(len(states), len(start)), *(states.index(name) for name in free_states))
    simulated = scan(Simulation(larger, parameters, larger.State(*start), (), places), inputs)
    unknowns = len(places)
    rows = simulated.values[:, len(outputs) :].reshape(len(inputs), len(outputs), unknowns)
    measured = [outputs.index(name) for name in noise]
    weights = np.array(list(noise.values()))
    sensitivities = (rows[:, measured] / weights[:, None]).reshape(-1, unknowns)
    return bound(sensitivities, (*free, *free_states))


def _value(parameters: Any, path: str) -> float:
    for name in path.split("."):
        parameters = getattr(parameters, name)
    return float(parameters)


def _names(kind: type) -> tuple[str, ...]:
    return tuple(path for path, _ in leaves(skeleton(kind)))


def _require_known(names: Any, known: tuple[str, ...], what: str) -> None:
    for name in names:
        if name not in known:
            raise ParameterError(f"the model has no {what} '{name}'{nearest(name, known)}")
