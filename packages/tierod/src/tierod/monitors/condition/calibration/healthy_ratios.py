"""Block maxima of the hypotheses' log-likelihood ratios on fault-free drives, as the basis of the limits."""

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
"""Warm-up at the beginning of every drive that is ignored [s]."""
BLOCK = 10.0
"""Length of a block, of which only the largest ratio counts [s]; the ratios are autocorrelated over some seconds."""
PIECE = 15
"""Blocks that are processed at once, which takes some 50 MB with all outputs."""
_NEVER = 1e6
"""Limit that no ratio exceeds [nat]."""


@dataclass(frozen=True)
class Watching:
    """Judge whose outputs are the smoothed ratios instead of decisions.

    Args:
        decision: decision with limits that no ratio exceeds
    """

    decision: Decision

    def feedback(self) -> Tree:
        """Feedback of the decision to the lanes."""
        return self.decision.feedback()

    def init(self) -> DecisionState:
        """State before the first sample: fault-free."""
        return self.decision.init()

    def step(self, state: DecisionState, sample: JudgeSample) -> tuple[DecisionState, Verdict]:
        """Process one sample."""
        after, verdict = self.decision.step(state, sample)
        return after, verdict._replace(output=after.weights)


class Watched(NamedTuple):
    """Outputs of the bank on a fault-free drive.

    Args:
        blocks: largest ratios of every block in which the vehicle moves, see `block_maxima`
        hours: time for which it moves
    """

    blocks: np.ndarray
    hours: Annotated[float, "h"]


def watch(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    progress: Callable[[float], None] = lambda share: None,
    bank: Bank | None = None,
) -> list[Watched]:
    """Ratios of all hypotheses on fault-free drives, without any declaration.

    Args:
        recordings: recordings of fault-free driving
        vehicle: vehicle with calibrated parameters
        progress: called with the completed share, 0 to 1
        bank: bank whose judge is a `Watching`; None takes the bank of the whole vehicle
    """
    bank, watched = bank or _watching(LeaveOutFilter.of_vehicle(vehicle), hypotheses()), []
    for place, recording in enumerate(recordings):
        watched.append(_watched(bank, aligned(recording)))
        progress((place + 1) / len(recordings))
    return watched


def _watched(bank: Bank, drive: np.ndarray) -> Watched:
    """Ratios of one drive, processed in pieces, since the outputs of an hour would fill the memory."""
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
    """Limits that no ratio exceeds, so that no fault is declared.

    Args:
        explanations: hypotheses, the fault-free one first
    """
    count = len(explanations) - 1
    return Limits((_NEVER,) * count, (_NEVER,) * count, 1.0, 1.0)


def block_maxima(ratios: np.ndarray, settling: float = SETTLING) -> np.ndarray:
    """Largest ratio of every block without the fault-free hypothesis, (blocks, 2 x hypotheses).

    Only ratios that last for three samples count, since the judge decides nothing earlier.

    Args:
        ratios: fast and slow means, the fault-free hypothesis first in both, (samples, 2 x hypotheses)
        settling: warm-up that is ignored [s]
    """
    count = ratios.shape[1] // 2
    width, skipped = round(BLOCK * RATE), round(settling * RATE)
    whole = max((len(ratios) - skipped) // width, 0)
    split = ratios[skipped : skipped + whole * width].reshape(whole, width, -1)
    return np.delete(lasting(split).max(axis=1), (0, count), axis=1)


def lasting(ratios: np.ndarray) -> np.ndarray:
    """Minimum over three consecutive samples, (..., samples - 2, ratios).

    Args:
        ratios: ratios, (..., samples, ratios)
    """
    return np.asarray(np.minimum(np.minimum(ratios[..., 2:, :], ratios[..., 1:-1, :]), ratios[..., :-2, :]))
