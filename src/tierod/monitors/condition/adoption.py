"""Which lane of the bank is believed in a sample, and which lanes go on from the state of another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tierod.graph import KEEP
from tierod.graph.maths import all_of, any_of, both, either, negated, where
from tierod.monitors.condition.signals import Hypothesis
from tierod.monitors.condition.weighing import chosen


def believed(
    hypotheses: Sequence[Hypothesis], likelihoods: Sequence[Any], active: Any, impossible: Any
) -> tuple[Any, list[Any]]:
    """The lane that is believed in a sample, and which lanes find the sample all but impossible.

    The active one is believed; where the sample is all but impossible to it, the likeliest of those that suspect all
    that it does.

    Args:
        hypotheses: in the order of the lanes
        likelihoods: logarithm of each hypothesis' density of this sample
        active: the number of the hypothesis that holds
        impossible: log-likelihood ratio against the best from which on a sample is all but impossible
    """
    best, top = active, chosen(likelihoods, active)
    own = top
    for number, value in enumerate(likelihoods):
        better = both(_contains(hypotheses, number, active), value > top)
        best, top = where(better, float(number), best), where(better, value, top)
    far_off = [value < top - impossible for value in likelihoods]
    return where(own < top - impossible, best, active), far_off


def adopted(hypotheses: Sequence[Hypothesis], source: Any, far_off: Sequence[Any], changed: Any) -> tuple[Any, ...]:
    """Whose state each lane goes on from; a lost share of torque is never taken over by another actuator's lane.

    Args:
        hypotheses: in the order of the lanes
        source: the lane whose state is taken over
        far_off: which lanes find the sample all but impossible
        changed: whether another hypothesis holds from now on, and all take over
    """
    adopting = []
    for number, own in enumerate(hypotheses):
        alien = [
            k
            for k, other in enumerate(hypotheses)
            if own.actuators and other.actuators and own.actuators != other.actuators
        ]
        foreign = any_of(0.0, *(source == k for k in alien))
        moves = all_of(either(changed, far_off[number]), negated(foreign), negated(source == number))
        adopting.append(where(moves, source, KEEP))
    return tuple(adopting)


def _contains(hypotheses: Sequence[Hypothesis], number: int, active: Any) -> Any:
    """Whether a hypothesis suspects all that the active one does."""
    own = set(hypotheses[number].suspects)
    parts = [k for k, each in enumerate(hypotheses) if set(each.suspects) <= own]
    return any_of(0.0, *(active == part for part in parts))
