"""Ratios of all hypotheses on fault-free drives, the largest of every ten seconds, on which limits are designed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Tree
from tierod.core.graph import Bank, JudgeSample, Verdict, scan
from tierod.core.recording import Recording
from tierod.monitors.condition.bank.decision import Decision, DecisionState
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.weighing import Limits, Weighing
from tierod.monitors.condition.calibration.grid import RATE, aligned, moving
from tierod.monitors.condition.hypotheses import Hypothesis, hypotheses
from tierod.vehicles import Vehicle

SETTLING = 2.0
"""Not looked at, at the beginning of every drive [s]."""
BLOCK = 10.0
"""Ratios are correlated over some seconds; of every such time the largest counts [s]."""
PIECE = 15
"""Blocks that are looked at in one go, which takes some 50 MB with what is worked out from them."""
_NEVER = 1e6


@dataclass(frozen=True)
class Watching:
    """A judge whose outputs are the smoothed ratios instead of its decisions.

    Args:
        decision: with limits that nothing exceeds
    """

    decision: Decision

    def feedback(self) -> Tree:
        """Feedback to the lanes."""
        return self.decision.feedback()

    def init(self) -> DecisionState:
        """Healthy."""
        return self.decision.init()

    def step(self, state: DecisionState, sample: JudgeSample) -> tuple[DecisionState, Verdict]:
        """One sample on."""
        after, verdict = self.decision.step(state, sample)
        return after, verdict._replace(output=after.weights)


class Watched(NamedTuple):
    """Outputs of the bank on a fault-free drive.

    Args:
        blocks: largest ratios of every ten seconds in which the vehicle moves, see `block_maxima`
        hours: for which it moves
    """

    blocks: np.ndarray
    hours: Annotated[float, "h"]


def watch(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    progress: Callable[[float], None] = lambda share: None,
    bank: Bank | None = None,
) -> list[Watched]:
    """The ratios of all hypotheses on drives, while none of them is declared.

    Args:
        recordings: of fault-free driving
        vehicle: with calibrated parameters
        progress: called with the share that is done
        bank: lanes with a judge that is `Watching`; that of the whole vehicle if None
    """
    bank, watched = bank or _watching(LeaveOutFilter.of_vehicle(vehicle), hypotheses()), []
    for place, recording in enumerate(recordings):
        watched.append(_watched(bank, aligned(recording)))
        progress((place + 1) / len(recordings))
    return watched


def _watched(bank: Bank, drive: np.ndarray) -> Watched:
    """One drive, piece by piece: the ratios of an hour would fill the memory."""
    width, skipped = round(BLOCK * RATE), round(SETTLING * RATE)
    end = skipped + max((len(drive) - skipped) // width, 0) * width
    explanations = bank.judge.decision.weighing.hypotheses
    found, state = [np.empty((0, 2 * len(explanations) - 2))], scan(bank, drive[:skipped]).state
    for begin in range(skipped, end, PIECE * width):
        result = scan(bank, drive[begin : min(begin + PIECE * width, end)], state)
        found.append(block_maxima(result.values, 0.0))
        state = result.state
    driven = moving(drive[skipped:end]).reshape(-1, width)
    return Watched(np.concatenate(found)[driven.any(axis=1)], float(np.count_nonzero(driven)) / (3600.0 * RATE))


def _watching(base: LeaveOutFilter, explanations: tuple[Hypothesis, ...]) -> Bank:
    lanes = tuple(base.leaving_out(each) for each in explanations)
    return Bank(lanes, Watching(Decision(Weighing(explanations, unreachable(explanations)))))


def unreachable(explanations: Sequence[Hypothesis]) -> Limits:
    """Limits that nothing exceeds, so that nothing is declared.

    Args:
        explanations: hypotheses, healthy first
    """
    count = len(explanations) - 1
    return Limits((_NEVER,) * count, (_NEVER,) * count, 1.0, 1.0)


def block_maxima(ratios: np.ndarray, settling: float = SETTLING) -> np.ndarray:
    """The largest ratio of every block, healthy left out, (blocks, 2 x hypotheses).

    Only what lasts for three samples counts, as the judge decides nothing before.

    Args:
        ratios: smoothed fast and slowly, the healthy hypothesis first in both, sample by sample
        settling: not looked at, at the beginning [s]
    """
    count = ratios.shape[1] // 2
    width, skipped = round(BLOCK * RATE), round(settling * RATE)
    whole = max((len(ratios) - skipped) // width, 0)
    split = ratios[skipped : skipped + whole * width].reshape(whole, width, -1)
    return np.delete(lasting(split).max(axis=1), (0, count), axis=1)


def lasting(ratios: np.ndarray) -> np.ndarray:
    """The least of three samples in a row, (..., samples - 2, ratios).

    Args:
        ratios: (..., samples, ratios)
    """
    return np.asarray(np.minimum(np.minimum(ratios[..., 2:, :], ratios[..., 1:-1, :]), ratios[..., :-2, :]))
