"""Adoption of lanes: the lane of the bank to use in a sample, and the lanes that go on from the state of another."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Scalar
from tierod.core.graph import KEEP
from tierod.core.graph.maths import all_of, any_of, both, either, greatest_of, negated, where
from tierod.monitors.condition.bank.weighing import chosen
from tierod.monitors.condition.hypotheses import SLIDING, Hypothesis


def selected_lane(
    hypotheses: Sequence[Hypothesis],
    likelihoods: Sequence[Scalar],
    active: Scalar,
    impossible: Scalar,
    slides: Scalar = 0.0,
) -> tuple[Scalar, Sequence[Scalar]]:
    """The lane that is used in a sample, and which lanes find the sample all but impossible.

    The active one is used; where the sample is all but impossible to it, the likeliest of those that suspect all
    that it does. A lane of actuators alone counts from where it is declared on: the loss of a fault-free one follows
    any disturbance.

    Args:
        hypotheses: in the order of the lanes
        likelihoods: logarithm of each hypothesis' density of this sample
        active: the number of the hypothesis that holds
        impossible: log-likelihood ratio against the best from which on a sample is all but impossible
        slides: whether tyres slide, so that the lane of sliding tyres, which then comes last, may be used
    """
    best, top = active, chosen(likelihoods, active)
    own = top
    for number, value in enumerate(likelihoods):
        if _keeps_to_itself(hypotheses[number]):
            continue
        better = both(_contains(hypotheses, number, active), value > top)
        better = both(better, slides) if hypotheses[number] is SLIDING else better
        best, top = where(better, float(number), best), where(better, value, top)
    far_off: list[Scalar] = [value < top - impossible for value in likelihoods]
    return where(own < top - impossible, best, active), far_off


def best_pair_containing(
    hypotheses: Sequence[Hypothesis], likelihoods: Sequence[Scalar], impossible: Scalar
) -> list[Scalar]:
    """Likeliest two-fault hypothesis that contains each single fault; 0 where it finds the sample impossible.

    Where two sensors disagree, either may be wrong; a lane that went on from one that uses the other sensor would
    count for the wrong one from then on.

    Args:
        hypotheses: in the order of the lanes
        likelihoods: logarithm of each hypothesis' density of this sample
        impossible: log-likelihood ratio against the best from which on a sample is all but impossible
    """
    top = greatest_of(*likelihoods)
    nearest = []
    for each in hypotheses:
        best: Scalar = 0.0
        highest = top - impossible
        for number, (other, value) in enumerate(zip(hypotheses, likelihoods, strict=True)):
            if each.suspects and each.agrees(other) and set(each.suspects) < set(other.suspects):
                better = value > highest
                best, highest = where(better, float(number), best), where(better, value, highest)
        nearest.append(best)
    return nearest


def adopted(
    hypotheses: Sequence[Hypothesis],
    source: Scalar,
    nearest: Sequence[Scalar],
    far_off: Sequence[Scalar],
    changed: Scalar,
    active: Scalar,
) -> tuple[Scalar, ...]:
    """State that each lane continues from; no lane takes over another actuator's lost share of torque.

    A lane of actuators alone goes on by itself until something is declared: it finds the loss within some samples, from
    which the state of a lane that leaves sensors out instead would lead it away.

    Args:
        hypotheses: in the order of the lanes
        source: the lane whose state is taken over
        nearest: of each lane another one that it rather takes over, see `best_pair_containing`; 0 if there is none
        far_off: which lanes find the sample all but impossible
        changed: whether another hypothesis holds from now on, and all take over the source
        active: the number of the hypothesis that holds from now on
    """
    adopting = []
    for number, own in enumerate(hypotheses):
        taken = where(either(changed, nearest[number] == 0.0), source, nearest[number])
        foreign = any_of(0.0, *(taken == k for k, other in enumerate(hypotheses) if not own.agrees(other)))
        lost = both(far_off[number], negated(active == 0.0)) if _keeps_to_itself(own) else far_off[number]
        moves = all_of(either(changed, lost), negated(foreign), negated(taken == number))
        adopting.append(where(moves, taken, KEEP))
    return tuple(adopting)


def _keeps_to_itself(hypothesis: Hypothesis) -> bool:
    """Whether the lane of a hypothesis shares its state with no other before anything is declared."""
    return bool(hypothesis.actuators) and not hypothesis.sensors


def _contains(hypotheses: Sequence[Hypothesis], number: int, active: Scalar) -> Scalar:
    """Whether a hypothesis suspects all that the active one does."""
    own = set(hypotheses[number].suspects)
    parts = [k for k, each in enumerate(hypotheses) if set(each.suspects) <= own]
    return any_of(0.0, *(active == part for part in parts))
