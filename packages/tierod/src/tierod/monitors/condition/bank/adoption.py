"""Adoption of states between lanes: the lane used in a sample, and the lanes that continue from another one's state."""

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
    """Lane that is used in a sample, and the lanes for which the sample is practically impossible.

    Normally this is the active lane. If the sample is practically impossible for it, the most likely lane is used that
    suspects at least the same elements. Lanes that suspect only actuators are excluded unless active, since the
    estimated loss of a fault-free actuator follows any disturbance.

    Args:
        hypotheses: hypotheses in the order of the lanes
        likelihoods: log-likelihood of this sample for each hypothesis [nat]
        active: number of the active hypothesis
        impossible: log-likelihood ratio to the best lane from which a sample is practically impossible [nat]
        slides: whether tyres slide, so that the lanes of sliding tyres, which come last, may be used

    Returns:
        number of the lane, and for each lane whether the sample is practically impossible
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
    """Most likely two-fault hypothesis that contains each single fault; 0 where the sample is impossible for it.

    If two sensors disagree, either may be faulty. A lane that continued from a lane which uses the other sensor would
    support the wrong hypothesis from then on; the pair uses neither.

    Args:
        hypotheses: hypotheses in the order of the lanes
        likelihoods: log-likelihood of this sample for each hypothesis [nat]
        impossible: log-likelihood ratio to the best lane from which a sample is practically impossible [nat]
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
    """Lane from whose state each lane continues; no lane adopts the lost torque of another actuator.

    A lane that suspects only actuators adopts no state until a fault is declared: it estimates the loss within some
    samples, and the state of a lane that leaves out sensors instead would lead it away from that estimate.

    Args:
        hypotheses: hypotheses in the order of the lanes
        source: number of the lane whose state is adopted
        nearest: for each lane, the lane that it adopts in preference, see `best_pair_containing`; 0 for none
        far_off: for each lane, whether the sample is practically impossible
        changed: whether the active hypothesis has changed, in which case all lanes adopt the source
        active: number of the active hypothesis from now on

    Returns:
        for each lane, the number of the adopted lane, or `KEEP`
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
    """Whether a hypothesis suspects only actuators, so that its lane adopts no state before a declaration."""
    return bool(hypothesis.actuators) and not hypothesis.sensors


def _contains(hypotheses: Sequence[Hypothesis], number: int, active: Scalar) -> Scalar:
    """Whether a hypothesis suspects at least the elements of the active one."""
    own = set(hypotheses[number].suspects)
    parts = [k for k, each in enumerate(hypotheses) if set(each.suspects) <= own]
    return any_of(0.0, *(active == part for part in parts))
