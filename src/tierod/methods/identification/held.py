"""Which parameter that was held does not fit the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.experiment import Estimate, Experiment, Free
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood

MARGIN = 0.1
"""Natural logarithm, per sample, by which recordings have to be likelier with a held parameter at another value before
the parameter is named: what a tenth less noise in one output makes, and a thousand times what chance makes in 10 s."""
_SHIFTS = (-0.9, -0.45, -0.2, 0.2, 0.45, 0.9)
"""Of the logarithm: factors from 0.4 to 2.5."""
_FITTED, _STEPS = 3, 10
"""Parameters that are looked for beside the others, the likeliest, and steps of each search: enough to tell them."""


class Misfit(NamedTuple):
    """A held parameter that does not fit.

    Args:
        name: of the parameter
        held: value at which it was held
        likelier: value near which the recordings are likelier
        gain: natural logarithm of how much, per sample
    """

    name: str
    held: float
    likelier: float
    gain: float


def misfit(
    search: MaximumLikelihood, estimate: Estimate, experiments: Sequence[Experiment], held: Sequence[str]
) -> Misfit | None:
    """The held parameter of which another value makes the recordings likelier by most; None where none does by much.

    The score, the slope of the likelihood by a held parameter, tells little as far away as a fit that failed may be. So
    every held parameter is put to other values, with the noises that were found and with the free parameters where the
    search ended and where it began; those that do best are then looked for beside the others.

    Args:
        search: that led to the estimate
        estimate: where it ended
        experiments: that were fitted
        held: parameters that may be wrong, all positive
    """
    samples = sum(len(each.inputs) for each in experiments)
    tried = [_best(search, estimate, experiments, name) for name in held if name not in estimate.names]
    found = []
    for _, name, place, wider in sorted(tried, key=lambda each: each[0])[:_FITTED]:
        fitted = wider.fit(experiments, place)
        gain = (estimate.cost - fitted.cost) / samples
        found.append(Misfit(name, float(getattr(search.parameters, name)), fitted[name], gain))
    worst = max(found, key=lambda each: each.gain, default=None)
    return worst if worst and worst.gain > MARGIN else None


def _best(
    search: MaximumLikelihood, estimate: Estimate, experiments: Sequence[Experiment], name: str
) -> tuple[float, str, np.ndarray, MaximumLikelihood]:
    """The least cost with one held parameter at other values; name, place, and the search in which it is free."""
    free = (*search.free, Free(name))
    wider = replace(search, free=free, starts=(), most_steps=_STEPS, begin_again=0)
    end, count = wider.place_of(estimate), len(free)
    places = []
    for place in (end, np.concatenate([wider.start()[:count], end[count:]])):
        for shift in _SHIFTS:
            moved = place.copy()
            moved[count - 1] += shift
            places.append(moved)
    costs = [wider.cost(place, experiments) for place in places]
    least = int(np.argmin(costs))
    return costs[least], name, places[least], wider
