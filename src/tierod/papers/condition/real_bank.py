"""The bank for cars whose torques nobody knows, on recordings of real cars: what it says, and how exactly it knows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.graph import Bank, scan
from tierod.core.recording import Recording
from tierod.monitors.condition.bank.rolling_filter import RollingFilter
from tierod.monitors.condition.calibration.grid import sampled
from tierod.monitors.condition.calibration.healthy_ratios import Watching, lasting, unreachable
from tierod.monitors.condition.hypotheses import hypotheses_of_cars
from tierod.monitors.condition.monitor import rolling_monitor
from tierod.papers.condition.by_bank import declared_of
from tierod.papers.condition.declared import Declared
from tierod.papers.condition.real_recordings import RATE, SENSORS, RealCar

SETTLED = 2.0
"""Not looked at, at the beginning of a recording [s]."""


def said(bank: Bank, recording: Recording) -> Declared:
    """What the bank says of a recording.

    Args:
        bank: of the car
        recording: as it was made, or with faults
    """
    samples = sampled(recording)
    return declared_of(scan(bank, samples.values), samples.time)


def accuracy(car: RealCar, recording: Recording) -> dict[str, float]:
    """How exactly the other sensors of a car tell each one's reading [unit of the sensor].

    The root of the mean squared error of the filter that leaves the sensor out, on the beginning of the recording.

    Args:
        car: whose recording it is
        recording: sound
    """
    samples, base = sampled(recording), RollingFilter.of_vehicle(car.known)
    found = {}
    for each in hypotheses_of_cars():
        if len(each.sensors) == 1:
            (name,) = each.sensors
            reading = samples.values[:, samples.names.index(name)]
            error = reading - scan(base.leaving_out(each), samples.values)[f"prediction.{name}"]
            since = samples.time - samples.time[0]
            looked_at = (since >= SETTLED) & (since < car.learning) & np.isfinite(error)
            found[name] = float(np.sqrt(np.mean(error[looked_at] ** 2)))
    return {name: found[name] for name in SENSORS}


def healthy_ratios(car: RealCar, recording: Recording, start: float, stop: float) -> tuple[float, float, float]:
    """The largest ratios of a stretch of a sound recording [nat].

    Over the short time those of hypotheses with and without wheels, over the long time that of any.

    Args:
        car: whose recording it is
        recording: sound
        start, stop: of the stretch, from the beginning of the recording [s]
    """
    explanations = hypotheses_of_cars()
    count = len(explanations) - 1
    bank = rolling_monitor(car.known, unreachable(explanations))
    ratios = scan(replace(bank, judge=Watching(bank.judge.decision)), sampled(recording).values).values
    largest = lasting(ratios[round(start * RATE) : round(stop * RATE)]).max(axis=0)
    fast, slow = largest[1 : count + 1], largest[count + 2 :]
    wheels = np.array([any(name in SENSORS[:2] for name in each.sensors) for each in explanations[1:]])
    return float(fast[wheels].max()), float(fast[~wheels].max()), float(slow.max())
