"""How well a shaft followed its reference, in figures."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tierod.papers.column.closed_loop import BEGIN, SAMPLE_TIME, ClosedLoop, Run, run
from tierod.papers.column.control.reference import Sweep


class Followed(NamedTuple):
    """Error of the gear's true angle against the reference.

    Args:
        rms, largest: of the error [deg]
        phase: of the angle against the reference, negative where late [deg]; NaN where no frequency was asked for
        found: how often a driver was found
    """

    rms: float
    largest: float
    phase: float
    found: int


def error(done: Run) -> np.ndarray:
    """Shaft less reference, true, over time [deg]."""
    return np.degrees(done.signals["plant.truth_gear_angle"] - done.reference.angle)


def followed(done: Run, after: float, until: float = math.inf, frequency: float = math.nan) -> Followed:
    """Figures of a stretch of a run.

    Args:
        done: the run
        after, until: the stretch; whole periods where a frequency is given [s]
        frequency: of a plain sine [Hz]
    """
    chosen = (done.time >= after - 0.5 * SAMPLE_TIME) & (done.time < until - 0.5 * SAMPLE_TIME)
    wrong = error(done)[chosen]
    phase = math.nan
    if math.isfinite(frequency):
        turning = np.exp(-2j * math.pi * frequency * done.time[chosen])
        shaft = done.signals["plant.truth_gear_angle"][chosen] @ turning
        phase = math.degrees(np.angle(shaft / (done.reference.angle[chosen] @ turning)))
    found = int(done.signals["controller.driver.found"].sum())
    return Followed(float(np.sqrt(np.mean(wrong**2))), float(np.abs(wrong).max()), phase, found)


def sine(loop: ClosedLoop, frequency: float, seed: int = 0, quick: bool = False) -> Followed:
    """A plain sine of 30 degrees, whole periods after it has settled."""
    periods = 1.0 if quick else max(2.0, round(4.0 * frequency))
    after = BEGIN + 2.0
    until = after + periods / frequency
    done = run(loop, Sweep(start=frequency, stop=frequency), until, seed)
    return followed(done, after, until, frequency)


def sweep(loop: ClosedLoop, seed: int = 0, quick: bool = False) -> tuple[Run, Followed]:
    """The sweep of figure 10, 0.1 to 3 Hz, and how well it was followed once it had faded in."""
    source = Sweep(duration=10.0) if quick else Sweep()
    done = run(loop, source, BEGIN + source.duration, seed)
    return done, followed(done, BEGIN + source.fade)
