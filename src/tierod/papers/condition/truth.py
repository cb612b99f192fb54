"""Declarations of a diagnosis over a drive, the truth, and from when a fault is observable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.recording import Recording
from tierod.papers.condition.drives import SENSORS, Drive
from tierod.papers.condition.faults import GAIN, LOSS, OUTLIER, STUCK, TARGETS, TORQUES, Injected
from tierod.papers.condition.recorded import RATE, deviations, fault_free
from tierod.vehicles import load

NOTHING: Mapping[str, np.ndarray] = {}
NOTHING_KNOWN: Mapping[str, float] = {}


KNOWN = {
    "wheel_speed_rear_left": 0.015,
    "wheel_speed_rear_right": 0.015,
    "yaw_rate": 0.01,
    "steering_wheel_angle": 0.1,
    "steering_shaft_torque": 0.35,
    "tie_rod_force": 45.0,
    "steering_motor_1": 0.5,
    "steering_motor_2": 0.5,
    "drive_left": 10.0,
    "drive_right": 10.0,
}
"""Accuracy with which all else estimates each element's true value: standard deviation [unit of the signal; N*m].

For sensors that is what is asked of a reconfigured value; for actuators it is assumed.
"""

ALIKE = 0.1
"""Over this time errors of the true value are alike, so that it counts once in a likelihood ratio [s]."""
ENOUGH = 4.5
"""Log-likelihood ratio from which a fault is observable: that of a deviation of three standard deviations."""


def where_shown(
    element: str, deviation: np.ndarray, faulty: np.ndarray, rate: float = 100.0, known: Mapping[str, float] = KNOWN
) -> np.ndarray:
    """Whether the fault of an element is observable at each sample.

    The logarithm of the likelihood ratio between "faulty" and "healthy" over the last `ALIKE` seconds, for whoever
    knows what the reading should be with a standard deviation of `known`: mean squared deviation / (2 * known**2).

    Args:
        element: sensor or actuator
        deviation: of its reading, or its torque, from what it would be without fault
        faulty: whether the fault is there
        rate: samples per second [Hz]
        known: standard deviation with which all else estimates each true value [unit of the signal; N*m]
    """
    count = max(round(ALIKE * rate), 1)
    largest = 1e3 * known[element]
    power = np.where(faulty, np.clip(np.asarray(deviation, float), -largest, largest), 0.0) ** 2
    total = np.concatenate([[0.0], np.cumsum(power)])
    past = np.minimum(np.arange(1, len(power) + 1), count)
    mean = (total[1:] - total[1 + np.arange(len(power)) - past]) / count
    enough: np.ndarray = faulty & (mean / (2.0 * known[element] ** 2) >= ENOUGH)
    return enough


def known_by_noise(drive: Drive) -> dict[str, float]:
    """Standard deviation of each true value given the motion and all parameters, over `ALIKE` seconds.

    No test can do better: only white noise and steps of the sensors are left, and a likelihood ratio averages them.
    Lost torque of a motor is read from the shaft's torque, that of a drive from the acceleration along the road.

    Args:
        drive: with its car and sensors

    Returns:
        by element [unit of the signal; N*m]
    """
    sensors, nominal = drive.driven.sensors, load("smartload")
    mean = math.sqrt(ALIKE * RATE)

    def noise(name: str) -> float:
        return math.hypot(sensors[name].noise, sensors[name].quantum / math.sqrt(12.0)) / mean

    torque = nominal["mass"] * nominal["wheel_radius"] * noise("longitudinal_acceleration")
    known = {name: noise(name) for name in SENSORS}
    known |= dict.fromkeys(("steering_motor_1", "steering_motor_2"), noise("steering_shaft_torque"))
    return known | dict.fromkeys(("drive_left", "drive_right"), torque)


class Declared(NamedTuple):
    """A diagnosis over time; elements that a mapping lacks count as never stated.

    Args:
        time: of the samples
        faulty: by element, whether it is declared faulty, and nothing else could be it
        candidates: by element, whether it is one of several that are named together as "one of these"
        not_testable: by element, whether its state is declared not testable now
        kind: by element, the kind that is named, "" for none; meaningful while it is faulty
        size: by element, the size that is named, in the unit of `faults.Injected`; NaN for none
        value: by sensor, what is given in its place, in its unit
        deviation: by element, the estimated standard deviation of the magnitude
    """

    time: Annotated[Any, "s"]
    faulty: Mapping[str, np.ndarray]
    candidates: Mapping[str, np.ndarray] = NOTHING
    not_testable: Mapping[str, np.ndarray] = NOTHING
    kind: Mapping[str, np.ndarray] = NOTHING
    size: Mapping[str, np.ndarray] = NOTHING
    value: Mapping[str, np.ndarray] = NOTHING
    deviation: Mapping[str, np.ndarray] = NOTHING

    def since(self, place: int) -> Declared:
        """Statements from one sample on."""
        parts = (getattr(self, name) for name in self._fields[1:])
        return Declared(self.time[place:], *({key: each[place:] for key, each in part.items()} for part in parts))

    def said(self, which: str, element: str) -> np.ndarray:
        """One of the mappings of truth values for one element; false everywhere where it is lacking."""
        found = getattr(self, which).get(element)
        return np.zeros(len(self.time), bool) if found is None else np.asarray(found, bool)


def truths(drive: Drive, time: np.ndarray) -> dict[str, np.ndarray]:
    """Whether each element is at fault at each sample, for those that ever are."""
    found: dict[str, np.ndarray] = {}
    for each in drive.injected:
        during = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
        found[each.element] = found.get(each.element, np.zeros(len(time), bool)) | during
    return found


class Truth(NamedTuple):
    """Ground truth for a diagnosis of a drive, on the samples of its recording.

    Args:
        off: by element that fails, how far it is from what it would be without fault, see `recorded.deviations`
        fault_free: by sensor that fails, what it would read without fault
        asked: by actuator that fails, the torque asked of it [N*m]
        known: standard deviation with which all else estimates each true value, see `where_shown`
        noise: the same of whoever knows motion and parameters, see `known_by_noise`; empty where nothing is strict
    """

    off: Mapping[str, np.ndarray]
    fault_free: Mapping[str, np.ndarray]
    asked: Mapping[str, np.ndarray]
    known: Mapping[str, float] = KNOWN
    noise: Mapping[str, float] = NOTHING_KNOWN

    @property
    def strict(self) -> Truth:
        """The same, where a fault is observable as soon as a test with true parameters detects it."""
        return self._replace(known=self.noise or self.known)

    def shows(self, element: str, there: np.ndarray) -> np.ndarray:
        """Whether the fault of an element is observable at each sample.

        Args:
            element: sensor or actuator
            there: whether the fault is
        """
        return where_shown(element, self.off[element], there, known=self.known)

    def would_show(self, each: Injected, time: np.ndarray) -> np.ndarray:
        """Whether a fault would be observable at each sample if it were always present."""
        return where_shown(each.element, self._would_be_off(each, time), np.ones(len(time), bool), known=self.known)

    def _would_be_off(self, each: Injected, time: np.ndarray) -> np.ndarray:
        if each.element in TORQUES:
            asked: np.ndarray = self.asked[each.element]
            return each.size * asked
        fault_free: np.ndarray = self.fault_free[each.element]
        if each.kind == LOSS:
            return fault_free
        if each.kind == STUCK:
            return fault_free - float(fault_free[min(int(np.searchsorted(time, each.start)), len(fault_free) - 1)])
        if each.kind in (GAIN, OUTLIER):
            return (each.size - 1.0) * fault_free
        return np.full(len(time), math.inf)


def truth_of(drive: Drive, recording: Recording) -> Truth:
    """The truth of a drive of the demonstrator."""
    sensors = drive.driven.sensors
    failing = {each.element for each in drive.injected}
    return Truth(
        deviations(drive, recording),
        {name: fault_free(name, recording, sensors) for name in failing.difference(TORQUES)},
        {name: recording[TARGETS[name]].values for name in failing.intersection(TORQUES)},
        noise=known_by_noise(drive),
    )
