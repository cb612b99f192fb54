"""The bank of filters as a diagnosis of the study, calibrated as the paper's rules are: on healthy drives alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.graph import Bank, scan
from tierod.monitors.condition.calibration import aligned
from tierod.monitors.condition.calibration import calibrate as calibrate_parameters
from tierod.monitors.condition.decision import Decision, judge
from tierod.monitors.condition.judge import condition_bank
from tierod.monitors.condition.kind import KINDS
from tierod.monitors.condition.lane import LeaveOutFilter, leaving_out
from tierod.monitors.condition.signals import ACTUATORS, SENSORS, hypotheses
from tierod.monitors.condition.weighing import Limits
from tierod.recording import Recording
from tierod.studies.condition.declared import Declared
from tierod.studies.condition.drives import calibration_drives
from tierod.studies.condition.recorded import recorded
from tierod.vehicles import Vehicle, load

FACTOR, FAST, SLOW, LEAST = 1.5, 2.0, 1.0, (0.5, 0.3)
"""A limit lies this factor above the largest healthy mean log-likelihood ratio, and this much at least.

Source: on the virtual demonstrator once the maximum gives alarms by the hour, 1.5 times none.
"""
SETTLING = 2.0
"""Not looked at, at the beginning of every drive [s]."""
RATE = 100.0


class Known:
    """A calibrated bank; put together where it is needed, since blocks are not sent.

    Args:
        vehicle: with the parameters found
        limits: of its hypotheses
    """

    def __init__(self, vehicle: Vehicle, limits: Limits):
        self.vehicle, self.limits = vehicle, limits
        self._bank: Bank | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without the blocks."""
        return {**self.__dict__, "_bank": None}

    @property
    def bank(self) -> Bank:
        """The bank at work."""
        if self._bank is None:
            self._bank = condition_bank(LeaveOutFilter.of_vehicle(self.vehicle), self.limits)
        return self._bank


def calibrate(number: int, quick: bool) -> Known:
    """Parameters from five healthy minutes of a vehicle, limits from an hour, or ten minutes if quick."""
    first, hour = calibration_drives(number)
    vehicle = calibrate_parameters([recorded(first)], load("smartload")).vehicle
    healthy = [recorded(each) for each in (hour[:1] if quick else hour)]
    return Known(vehicle, limits_of(LeaveOutFilter.of_vehicle(vehicle), healthy))


@dataclass(frozen=True)
class Watching:
    """A judge that tells the smoothed ratios instead of what it decides.

    Args:
        decision: with limits that nothing exceeds
    """

    decision: Decision

    def feedback(self) -> Any:
        """What lanes are told."""
        return self.decision.feedback()

    def init(self) -> Any:
        """Healthy."""
        return self.decision.init()

    def step(self, state: Any, sample: Any) -> Any:
        """One sample on."""
        after, verdict = self.decision.step(state, sample)
        return after, verdict._replace(output=after.weights)


def limits_of(base: LeaveOutFilter, healthy: Sequence[Recording]) -> Limits:
    """Limits above all that healthy drives show.

    Args:
        base: filter that suspects nobody
        healthy: drives without fault
    """
    explanations = hypotheses()
    count = len(explanations) - 1
    never = Limits((1e6,) * count, (1e6,) * count, 1.0, 1.0)
    bank = Bank(tuple(leaving_out(each, base) for each in explanations), Watching(judge(explanations, never)))
    settled = round(SETTLING * RATE)
    results = [scan(bank, aligned(each)) for each in healthy]
    largest = np.max([[np.max(each[name][settled:]) for name in each.names] for each in results], axis=0)
    fast, slow = largest[1 : count + 1], largest[count + 2 :]
    return Limits(
        tuple(float(max(FACTOR * each, each + FAST, LEAST[0])) for each in fast),
        tuple(float(max(FACTOR * each, each + SLOW, LEAST[1])) for each in slow),
        1.0,
        1.0,
    )


def declare(known: Known, recording: Recording, name: str) -> Declared:
    """What the bank says of a drive."""
    result = scan(known.bank, aligned(recording))
    elements = (*SENSORS, *ACTUATORS)
    names = np.array(["", *KINDS])
    share = result["loss.share"]
    return Declared(
        recording["yaw_rate"].time,
        {each: result[f"decision.faulty.{each}"] > 0.5 for each in elements},
        {each: result[f"decision.candidates.{each}"] > 0.5 for each in elements},
        {each: result[f"decision.testable.{each}"] < 0.5 for each in elements},
        {each: names[np.rint(result[f"kinds.{each}.kind"]).astype(int)] for each in SENSORS}
        | {each: np.where(result[f"decision.faulty.{each}"] > 0.5, "loss", "") for each in ACTUATORS},
        {each: result[f"kinds.{each}.size"] for each in SENSORS} | dict.fromkeys(ACTUATORS, share),
        {each: result[f"decision.value.{each}"] for each in SENSORS},
    )
