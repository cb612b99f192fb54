"""Runs of the swept bench through observers of the column, and their errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import scan
from tierod.experiments.effort import Effort
from tierod.papers.column.swept_bench import HANDS, swept

FROM = 0.5
"""Errors count from here on: the observers begin at rest with nothing known [s]."""

SIGNALS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
"""Columns of `ColumnSample`."""

Change = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Errors:
    """Root mean square errors over some runs.

    Args:
        hand_torque: [N m]
        disturbance_torque: [N m]; NaN where it is not told
        nis: mean normalised innovation squared; NaN likewise
    """

    hand_torque: float
    disturbance_torque: float
    nis: float


def seeds(effort: Effort) -> tuple[int, ...]:
    """Of the runs that are reported; the observers were tuned on 1 and 2."""
    return (11,) if effort.quick else (11, 12, 13, 14, 15)


@lru_cache(maxsize=64)
def drive(hands: str, seed: int, pace: str = "octaves") -> dict[str, np.ndarray]:
    """One run of the bench of 40 s, kept."""
    return swept(hands, 40.0, seed, pace=pace)


def samples(run: dict[str, np.ndarray]) -> np.ndarray:
    """What an observer is given, in the order of `ColumnSample`."""
    return np.column_stack([run[name] for name in SIGNALS])


def errors(
    block: Block, hands: str, effort: Effort, delay: int = 0, change: Change | None = None, pace: str = "octaves"
) -> Errors:
    """Errors of an observer over the runs that are reported.

    Args:
        block: observer of `ColumnSample`
        hands: what the hands do
        effort: how many runs
        delay: samples by which the estimate is late
        change: what is done to the samples before
        pace: of the sweep
    """
    hand, disturbance, nis = [], [], []
    for seed in seeds(effort):
        run = drive(hands, seed, pace)
        given = samples(run)
        found = scan(block, given if change is None else change(given))
        late = slice(delay, None)
        true = {name: run[name][: len(given) - delay] for name in ("hand_torque", "disturbance_torque", "time")}
        counted = true["time"] > FROM
        hand.append((found["hand_torque"][late] - true["hand_torque"])[counted])
        if "disturbance_torque" in found.names:
            disturbance.append((found["disturbance_torque"][late] - true["disturbance_torque"])[counted])
        if "nis" in found.names:
            nis.append(found["nis"][late][counted])
    return Errors(rms(hand), rms(disturbance), float(np.mean(np.concatenate(nis))) if nis else float("nan"))


def rms(parts: Sequence[Any]) -> float:
    """Root mean square over all parts; NaN where there is none."""
    return float(np.sqrt(np.mean(np.square(np.concatenate(parts))))) if len(parts) else float("nan")


def over_hands(
    block: Block, effort: Effort, delay: int = 0, change: Change | None = None, pace: str = "octaves"
) -> dict[str, Errors]:
    """Errors of an observer for everything that the hands may do."""
    return {hands: errors(block, hands, effort, delay, change, pace) for hands in HANDS}
