"""Declarations of a diagnosis over a drive, the truth, and the observability of faults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import GAIN, LOSS, OUTLIER, SENSORS, STUCK, TARGETS, TORQUES, Drive, Injected
from tierod_lab.papers.condition.recorded import RATE, deviations, fault_free

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
"""Standard deviation with which all other signals estimate the true value of each element [unit of the signal; N*m].

For sensors it is the accuracy required of a reconfigured value; for actuators it is assumed.
"""

ALIKE = 0.1  # Correlation time of the estimation error [s]; samples within it count as one in a log-likelihood ratio
ENOUGH = 4.5  # Log-likelihood ratio from which a fault is observable [nat]: that of three standard deviations


def where_shown(
    element: str, deviation: np.ndarray, faulty: np.ndarray, rate: float = 100.0, known: Mapping[str, float] = KNOWN
) -> np.ndarray:
    """Whether the fault of an element is observable at each sample.

    The criterion is the log-likelihood ratio of "faulty" against "fault-free" over the last `ALIKE` seconds, if the
    true value is known with the standard deviation `known`: mean squared deviation / (2 * known**2).

    Args:
        element: sensor or actuator
        deviation: deviation of its reading or torque from the fault-free value
        rate: sampling rate [Hz]
        known: standard deviation of the estimate of each true value [unit of the signal; N*m]
    """
    count = max(round(ALIKE * rate), 1)
    # Infinite deviations, of faults that always show, would make the running sums below NaN.
    largest = 1e3 * known[element]
    power = np.where(faulty, np.clip(np.asarray(deviation, float), -largest, largest), 0.0) ** 2
    total = np.concatenate([[0.0], np.cumsum(power)])
    past = np.minimum(np.arange(1, len(power) + 1), count)
    # Divided by the full window at the start as well, where there is less evidence.
    mean = (total[1:] - total[1 + np.arange(len(power)) - past]) / count
    enough: np.ndarray = faulty & (mean / (2.0 * known[element] ** 2) >= ENOUGH)
    return enough


def known_by_noise(drive: Drive) -> dict[str, float]:
    """Standard deviation of each true value over `ALIKE` seconds if motion and all parameters are known.

    It is a lower bound for any test: only white noise and quantisation of the sensors are left, and the log-likelihood
    ratio averages them. The lost torque of a motor shows in the shaft torque, that of a drive in the longitudinal
    acceleration.

    Returns:
        standard deviation by element [unit of the signal; N*m]
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
    """Declarations of a diagnosis over time; an element that a mapping lacks is never declared."""

    time: Annotated[Any, "s"]  # sampling times
    faulty: Mapping[str, np.ndarray]  # by element, whether it is declared faulty
    candidates: Mapping[str, np.ndarray] = NOTHING  # by element, whether it is one of several candidates for a fault
    not_testable: Mapping[str, np.ndarray] = NOTHING  # by element, whether it is declared not testable
    # by element, the named kind, "" for none; valid while the element is faulty
    kind: Mapping[str, np.ndarray] = NOTHING
    # by element, the named size in the unit of `faults.Injected`; NaN for none
    size: Mapping[str, np.ndarray] = NOTHING
    value: Mapping[str, np.ndarray] = NOTHING  # by sensor, its substitute value in its unit
    deviation: Mapping[str, np.ndarray] = NOTHING  # by element, the estimated standard deviation of the size

    def since(self, place: int) -> Declared:
        """The declarations from a sample on."""
        parts = (getattr(self, name) for name in self._fields[1:])
        return Declared(self.time[place:], *({key: each[place:] for key, each in part.items()} for part in parts))

    def said(self, which: str, element: str) -> np.ndarray:
        """Flags of one element in the mapping `which`; all false for an element that it lacks."""
        found = getattr(self, which).get(element)
        return np.zeros(len(self.time), bool) if found is None else np.asarray(found, bool)


def truths(drive: Drive, time: np.ndarray) -> dict[str, np.ndarray]:
    """Element -> whether it is faulty at each sample, for the elements with an injected fault."""
    found: dict[str, np.ndarray] = {}
    for each in drive.injected:
        # The tolerance absorbs the rounding of the sampling times.
        during = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
        found[each.element] = found.get(each.element, np.zeros(len(time), bool)) | during
    return found


class Truth(NamedTuple):
    """Ground truth for a diagnosis of a drive, on the samples of its recording."""

    # by faulty element, its deviation from the fault-free value, see `recorded.deviations`
    off: Mapping[str, np.ndarray]
    fault_free: Mapping[str, np.ndarray]  # by faulty sensor, its fault-free reading
    asked: Mapping[str, np.ndarray]  # by faulty actuator, its commanded torque [N*m]
    known: Mapping[str, float] = KNOWN  # standard deviation of the estimate of each true value, see `where_shown`
    # the same if motion and parameters are known, see `known_by_noise`; empty where there is no strict score
    noise: Mapping[str, float] = NOTHING_KNOWN

    @property
    def strict(self) -> Truth:
        """The truth with faults that are observable where a likelihood-ratio test with true parameters detects them."""
        return self._replace(known=self.noise or self.known)

    def shows(self, element: str, there: np.ndarray) -> np.ndarray:
        """Whether the fault of an element is observable at each sample.

        Args:
            element: sensor or actuator
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
        # The other kinds would show at any reading.
        return np.full(len(time), math.inf)


def observable(drive: Drive, recording: Recording) -> tuple[float, float]:
    """Observable share of the time of a fault [-], and time from it until it is observable [s]; infinite for never."""
    time, fault = recording["yaw_rate"].time, drive.injected[0]
    there = truths(drive, time)[fault.element]
    shows = truth_of(drive, recording).shows(fault.element, there)
    first = float(time[np.argmax(shows)] - fault.start) if shows.any() else math.inf
    return float(np.mean(shows[there])), first


def truth_of(drive: Drive, recording: Recording) -> Truth:
    """The truth of a drive of the demonstrator, with the noise of its sensors for the strict score."""
    sensors = drive.driven.sensors
    failing = {each.element for each in drive.injected}
    return Truth(
        deviations(drive, recording),
        {name: fault_free(name, recording, sensors) for name in failing.difference(TORQUES)},
        {name: recording[TARGETS[name]].values for name in failing.intersection(TORQUES)},
        noise=known_by_noise(drive),
    )
