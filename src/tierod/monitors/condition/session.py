"""The condition monitor over one recording: states of sensors and actuators, substitutes, and the finding."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tierod.block import Block
from tierod.graph import Memory, Result, scan
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.courses import ElementCourse
from tierod.monitors.condition.finding import Drive, code_courses, elements, judge
from tierod.monitors.condition.said import ELEMENTS, Said
from tierod.monitors.condition.signals import ACTUATORS, SENSORS, ConditionSample
from tierod.monitors.condition.substitutes import Reconfiguration
from tierod.monitors.condition.wiring import Wiring
from tierod.monitors.session import Conclusion
from tierod.recording import Aligned
from tierod.signals import SIGNALS
from tierod.vehicles import Vehicle

SLICE = 60_000
"""Samples that are judged at once, lest all outputs of a long piece lie in memory together."""
LOST = 1.0
"""Without any reading of any sensor for so long, the monitor begins anew: the vehicle was switched off [s]."""
SPEED = 0.5
"""Below which the vehicle stands [m/s]."""

TARGETS: Mapping[str, tuple[str, ...]] = {
    "steering_motor_1": ("steering_motor_1_target_torque",),
    "steering_motor_2": ("steering_motor_2_target_torque",),
    "drive_left": ("target_drive_torque_left",),
    "drive_right": ("target_drive_torque_right",),
}
"""Without which an actuator cannot be judged."""


class ConditionSession:
    """Runs a variant over a recording, piece by piece.

    Args:
        name: of monitor and variant
        block: of the variant
        said: from its outputs to what is said of every element
        filtered: from its outputs to what it says in place of every sensor, (n, sensors)
        vehicle: that is judged
        rate: of the samples [Hz]
        calibrated: whether its limits were designed on this very vehicle
    """

    def __init__(
        self,
        name: str,
        block: Block,
        said: Callable[[Result], Said],
        filtered: Callable[[Result], np.ndarray],
        vehicle: Vehicle,
        rate: float,
        calibrated: bool,
    ):
        self.name, self.block, self.vehicle, self.rate, self.calibrated = name, block, vehicle, rate, calibrated
        self.signals: tuple[str, ...] = ConditionSample._fields
        self.reconfiguration = Reconfiguration.of_vehicle(vehicle, 1.0 / rate)
        self.traces: Mapping[str, str] = {
            **{f"state_of_{each}": "" for each in ELEMENTS},
            **{f"supplied_{each}": SIGNALS[each].unit for each in SENSORS},
        }
        self._said, self._filtered = said, filtered
        self._wiring = Wiring(vehicle.parameters_for(AutomatedVehicle.Parameters), rate)
        self._courses = {each: ElementCourse(each, 1.0 / rate) for each in ELEMENTS}
        self._memory: Memory | None = None
        self._supply: Memory | None = None
        self._silent = 0
        self._drive = Drive()

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Take in one more piece and give the traces over it, (n,) each."""
        parts = [self._slice(aligned, part) for part in self._slices(aligned.values)]
        return {name: np.concatenate([part[name] for part in parts]) for name in self.traces}

    def _slices(self, values: np.ndarray) -> list[tuple[slice, bool]]:
        """Slices of a piece, and whether the monitor begins anew with each."""
        there = np.isfinite(values[:, : len(SENSORS)]).any(axis=1)
        place = np.arange(len(values))
        before = np.concatenate([[-1 - self._silent], np.maximum.accumulate(np.where(there, place, -1 - self._silent))])
        again = np.flatnonzero(there & (place - before[:-1] > LOST * self.rate))
        self._silent = int(len(values) - 1 - before[-1])
        starts = sorted({0, *again.tolist(), *range(0, len(values), SLICE)})
        stops = [*starts[1:], len(values)]
        anew = set(again.tolist()) if self._memory is not None or len(again) else set()
        return [(slice(start, stop), start in anew) for start, stop in zip(starts, stops, strict=True)]

    def _slice(self, aligned: Aligned, part: tuple[slice, bool]) -> dict[str, np.ndarray]:
        where, anew = part
        time, values = aligned.time[where], aligned.values[where]
        signals = dict(zip(aligned.names, values.T, strict=True))
        if anew:
            self._memory = self._supply = None
            self._drive.restarts += 1
        result = scan(self.block, Aligned(time, values, aligned.names), self._memory)
        self._memory = result.state
        said = self._said(result)
        self._wiring.add(signals)
        self._drive.add(time, signals, 1.0 / self.rate)
        for name, course in self._courses.items():
            course.add(time, said, _available(name, signals))
        supplied = self._supplied(signals, said, self._filtered(result))
        self._drive.add_sources(supplied, self.reconfiguration.switchover.graph)
        states = np.where(said.faulty, 1.0, np.where(said.candidates, 0.5, 0.0))
        return {
            **{f"state_of_{name}": states[:, place] for place, name in enumerate(ELEMENTS)},
            **{f"supplied_{name}": supplied[f"{name}.value"] for name in SENSORS},
        }

    def _supplied(self, signals: Mapping[str, np.ndarray], said: Said, filtered: np.ndarray) -> Result:
        """Every sensor's signal as others may use it."""
        readings = np.column_stack([signals[name] for name in ConditionSample._fields])
        faulty = said.faulty[:, : len(SENSORS)].astype(float)
        result = scan(self.reconfiguration, np.hstack([readings, faulty, filtered]), self._supply)
        self._supply = result.state
        return result

    def conclude(self) -> Conclusion:
        """The state of every element, and the finding."""
        problems = self._wiring.problems()
        states = elements(self._courses, self._drive, problems, self.reconfiguration.switchover.graph)
        finding = judge(self.name, states, self._drive, problems, self.calibrated)
        if problems:
            # What was wired wrongly is nobody's fault, and must fill no fault memory.
            return Conclusion(finding, elements=states)
        courses = code_courses(self._courses)
        return Conclusion(finding, elements=states, code_courses=courses)


def _available(name: str, signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Whether an element can be judged: its own signal, or its targets, come at all."""
    needed = TARGETS[name] if name in ACTUATORS else (name,)
    there: Any = np.isfinite(np.column_stack([signals[each] for each in needed])).all(axis=1)
    # Between the readings of a slow channel nothing is missing.
    return np.full(len(there), bool(there.any()))


def filtered_by_bank(result: Result) -> np.ndarray:
    """What the bank says in place of every sensor, (n, sensors)."""
    return np.column_stack([result[f"decision.value.{name}"] for name in SENSORS])


def filtered_by_rules(result: Result) -> np.ndarray:
    """What the models of the residuals say in place of every sensor, (n, sensors)."""
    return np.column_stack([result[f"expected.{name}"] for name in SENSORS])
