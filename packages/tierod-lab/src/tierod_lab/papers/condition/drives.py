"""Drives of the study and the faults that are put into them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Annotated, Any

from tierod_lab.ground.faults import Delay, Drift, Fault, Gain, Noise, Offset, Outlier, Stuck, TorqueLoss, TotalLoss
from tierod_lab.ground.faults.fault import AtTime
from tierod_lab.papers.condition.vehicles import LATER, LONG, SHORT, THIRD, Vehicle, changed, vehicle

LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY = (
    *("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay"),
)
KINDS = (LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY)  # Kinds of sensor faults; an actuator has losses only

OFFSETS = {
    "wheel_speed_rear_left": 2.0,
    "wheel_speed_rear_right": 2.0,
    "yaw_rate": 0.3,
    "steering_wheel_angle": 1.5,
    "steering_shaft_torque": 3.0,
    "tie_rod_force": 250.0,
}
"""Offset of every sensor in the tests, in the unit of its signal; the paper prints none."""

OUTLIER_FACTOR = 3.0  # Factor on the signal during an outlier of one second; the paper prints none

TORQUES = {
    "steering_motor_1": "steering_motor_1_torque",
    "steering_motor_2": "steering_motor_2_torque",
    "drive_left": "drive_torque_left",
    "drive_right": "drive_torque_right",
}
"""Actuator -> channel of its torque."""

TARGETS = {
    "steering_motor_1": "steering_motor_1_target_torque",
    "steering_motor_2": "steering_motor_2_target_torque",
    "drive_left": "target_drive_torque_left",
    "drive_right": "target_drive_torque_right",
}
"""Actuator -> channel of its commanded torque."""

_READ_IN_THE_LOOP = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle")


@dataclass(frozen=True)
class Injected:
    """One injected fault of a drive, the truth for its score."""

    element: str  # signal of a sensor, or name of an actuator ("steering_motor_1")
    kind: str  # one of `KINDS`
    # fault magnitude: offset in the unit of the signal, factor of a gain or outlier, drift per second, standard
    # deviation of noise, delay in seconds, lost share of an actuator's torque; NaN for a kind without one
    size: float = math.nan
    start: Annotated[float, "s"] = 20.0  # start, end: beginning and end of the fault
    end: Annotated[float, "s"] = 40.0
    in_the_loop: bool = False  # whether the automated driver uses the faulty reading, as well as the recording

    @property
    def name(self) -> str:
        """Element, kind and size, for tables."""
        size = "" if math.isnan(self.size) else f" {self.size:g}"
        return f"{self.element} {self.kind}{size}"

    @property
    def in_recording_alone(self) -> bool:
        """Whether the fault affects the recording alone, as in a sensor that no controller uses."""
        return self.element not in TORQUES and not (self.in_the_loop and self.element in _READ_IN_THE_LOOP)

    @property
    def fault(self) -> Fault:
        """The fault as an object of the proving ground."""
        lasts, trigger = self.end - self.start, AtTime(self.start)
        if self.element in TORQUES:
            return Fault(f"actuator.{TORQUES[self.element]}", TorqueLoss(self.size), trigger, lasts)
        prefix = "sensor." if self.in_recording_alone else ""
        return Fault(f"{prefix}{self.element}", self._behaviour, trigger, lasts)

    @property
    def _behaviour(self) -> Any:
        if self.kind == LOSS:
            return TotalLoss()
        if self.kind == STUCK:
            return Stuck()
        sized = {OFFSET: Offset, GAIN: Gain, DRIFT: Drift, OUTLIER: Outlier, NOISE: Noise, DELAY: Delay}
        return sized[self.kind](self.size)


def lost(actuator: str, share: float = 1.0, start: float = 104.0, end: float = 200.0) -> Injected:
    """A loss of torque of an actuator.

    Args:
        share: lost share of the torque [-]
        start, end: beginning and end of the fault [s]; by default those of Figures 12 to 17 of Li, Frey, Gauterin
    """
    return Injected(actuator, LOSS, share, start, end)


SENSORS = tuple(OFFSETS)  # Sensors into which faults are injected
ACTUATORS = ("steering_motor_1", "steering_motor_2", "drive_left", "drive_right")
"""Actuators into which faults are injected."""

TEST_SECONDS, ACTUATOR_SECONDS = 60.0, 200.0  # Duration of the paper's tests of sensors and of actuators [s]
LEG = 600.0  # Longest duration of a single drive [s]
UNSEEN = 1000  # First number of the random rounds that no calibration uses


@dataclass(frozen=True)
class Drive:
    """One drive to be recorded."""

    course: str  # name of a course, see `vehicles.course`
    seconds: Annotated[float, "s"]  # duration
    vehicle: int = 1  # number of the demonstrator, see `vehicles.vehicle`
    seed: int = 0  # seed of sensor noise, slopes and wind
    injected: tuple[Injected, ...] = ()  # injected faults
    swing: bool = True  # whether the split of the steering torque alternates
    # property that has changed since the calibration, and its factor, see `vehicles.changed`
    later: tuple[str, float] | None = None

    @property
    def name(self) -> str:
        """Name by faults, course, vehicle and seed."""
        faults = ", ".join(each.name for each in self.injected) or "healthy"
        later = f", {self.later[0]} times {self.later[1]:g}" if self.later else ""
        return f"{faults}, {self.course}, vehicle {self.vehicle}{later}, seed {self.seed}"

    @property
    def driven(self) -> Vehicle:
        """The demonstrator and its sensors, as changed since the calibration."""
        known = vehicle(self.vehicle, self.swing)
        return changed(known, *self.later) if self.later else known


def calibration_drives(vehicle: int = 1, swing: bool = True) -> tuple[Drive, tuple[Drive, ...]]:
    """Fault-free drives on random rounds: five minutes for the parameters, and an hour for the thresholds.

    Args:
        swing: see `Drive`
    """
    first = Drive("round-0", 300.0, vehicle, 900 + vehicle, (), swing)
    hour = tuple(Drive(f"round-{leg + 1}", LEG, vehicle, 910 + 10 * vehicle + leg, (), swing) for leg in range(6))
    return first, hour


def healthy_drives(hours: float, vehicles: Sequence[int] = (1, 2, 3), swing: bool = True) -> list[Drive]:
    """Fault-free drives on rounds that no calibration uses, ten minutes each, with the vehicles in turn.

    Args:
        hours: total duration [h]
        swing: see `Drive`
    """
    count = max(round(hours * 3600.0 / LEG), 1)
    seconds = min(hours * 3600.0, LEG)
    first = 1000 * (vehicles[0] - 1)  # other demonstrators, other rounds
    return [
        Drive(f"round-{first + UNSEEN + leg}", seconds, vehicles[leg % len(vehicles)], first + 2000 + leg, (), swing)
        for leg in range(count)
    ]


def changed_drives(hours: float, share: float = 0.1, vehicles: Sequence[int] = (1, 2, 3)) -> list[Drive]:
    """Fault-free drives of vehicles whose mass, cornering stiffness or tyre radius has changed since the calibration.

    Args:
        hours: total duration [h]
        share: relative change, up and down in turn [-]
    """
    # A change stays for one turn of all vehicles, so that every vehicle gets every change.
    changes = [(what, 1.0 + sign * share) for what in LATER for sign in (1.0, -1.0)]
    drives = healthy_drives(hours, vehicles)
    return [
        replace(each, seed=each.seed + 1000, later=changes[leg // len(vehicles) % len(changes)])
        for leg, each in enumerate(drives)
    ]


def kinds_of_the_paper(sensor: str, in_the_loop: bool = False) -> tuple[Injected, ...]:
    """Faults of the paper's tests: total loss, offset of either sign, and an outlier of one second, from 20 s on.

    Source: Li, Frey, Gauterin, section 5; sizes of `faults`.
    """
    size = OFFSETS[sensor]
    return (
        Injected(sensor, LOSS, in_the_loop=in_the_loop),
        Injected(sensor, OFFSET, size, in_the_loop=in_the_loop),
        Injected(sensor, OFFSET, -size, in_the_loop=in_the_loop),
        Injected(sensor, OUTLIER, OUTLIER_FACTOR, end=21.0, in_the_loop=in_the_loop),
    )


def sensor_tests(vehicle: int = 1, in_the_loop: bool = False, swing: bool = True) -> list[Drive]:
    """The 48 tests of the sensors: six sensors, four faults, short and long round.

    Args:
        in_the_loop: whether the automated driver uses the faulty reading as well
        swing: see `Drive`
    """
    return [
        Drive(course, TEST_SECONDS, vehicle, 10 + vehicle, (injected,), swing)
        for sensor in SENSORS
        for injected in kinds_of_the_paper(sensor, in_the_loop)
        for course in (SHORT, LONG)
    ]


def actuator_tests(vehicle: int = 1, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """The nine tests of the actuators: either steering motor or one drive lost, on three rounds.

    The paper has three losses on each of three rounds, but does not list them. Here the right drive fails on the long
    round, the left one on the two others.

    Args:
        share: lost share of the torque [-]
        swing: see `Drive`
    """
    drives = {SHORT: "drive_left", LONG: "drive_right", THIRD: "drive_left"}
    return [
        Drive(course, ACTUATOR_SECONDS, vehicle, 20 + vehicle, (lost(actuator, share),), swing)
        for course, drive in drives.items()
        for actuator in ("steering_motor_1", "steering_motor_2", drive)
    ]


def supply_tests(vehicle: int = 1, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """Tests with a common cause, such as a lost supply: both steering motors or both drives lost, on three rounds.

    Args:
        share: share of the torque that both lose [-]
        swing: see `Drive`
    """
    return [
        Drive(course, ACTUATOR_SECONDS, vehicle, 20 + vehicle, tuple(lost(name, share) for name in pair), swing)
        for course in (SHORT, LONG, THIRD)
        for pair in (ACTUATORS[:2], ACTUATORS[2:])
    ]


def both_motors(vehicle: int = 1, swing: bool = True) -> Drive:
    """Drive with both steering motors without torque from 104 s on, as in Figures 12 to 14 of the paper."""
    return Drive(SHORT, 106.0, vehicle, 20 + vehicle, (lost("steering_motor_1"), lost("steering_motor_2")), swing)


def more_kinds(
    vehicle: int = 1, course: str = SHORT, seed: int = 0, sizes: Sequence[float] = (1.0,), seconds: float = TEST_SECONDS
) -> list[Drive]:
    """Drives with every kind of fault of every sensor, in several sizes.

    Args:
        course, seed, seconds: see `Drive`
        sizes: multiples of the offset of the tests; the other kinds are scaled to disturb the reading as much
    """
    drives = []
    for sensor, size in product(SENSORS, sizes):
        amount = size * OFFSETS[sensor]
        several = [
            Injected(sensor, OFFSET, amount),
            Injected(sensor, OFFSET, -amount),
            Injected(sensor, GAIN, 1.0 + 0.5 * size),
            Injected(sensor, GAIN, 1.0 / (1.0 + 0.5 * size)),
            Injected(sensor, DRIFT, 0.1 * amount),
            Injected(sensor, NOISE, 0.5 * amount),
            Injected(sensor, DELAY, 0.2 * size),
        ]
        if size == 1.0:
            several += [Injected(sensor, LOSS), Injected(sensor, STUCK), Injected(sensor, OUTLIER, 3.0, end=21.0)]
        drives += [Drive(course, seconds, vehicle, seed, (injected,)) for injected in several]
    return drives


def sensor_pairs(vehicle: int = 1, course: str = SHORT, seed: int = 0) -> list[Drive]:
    """Drives with each of the 15 pairs of sensors, both lost or both with offsets; the second fails 2 s later."""
    drives = []
    for first, second in combinations(SENSORS, 2):
        lost_pair = (Injected(first, LOSS), Injected(second, LOSS, start=22.0))
        off_pair = (Injected(first, OFFSET, OFFSETS[first]), Injected(second, OFFSET, OFFSETS[second], start=22.0))
        drives += [Drive(course, TEST_SECONDS, vehicle, seed, pair) for pair in (lost_pair, off_pair)]
    return drives


def mixed_pairs(vehicle: int = 1, course: str = SHORT, seed: int = 0, share: float = 1.0) -> list[Drive]:
    """Drives with an offset of every sensor and, 2 s later, a lost share of the torque of every actuator."""
    return [
        Drive(
            course,
            TEST_SECONDS,
            vehicle,
            seed,
            (Injected(sensor, OFFSET, OFFSETS[sensor]), lost(actuator, share, 22.0, 40.0)),
        )
        for sensor, actuator in product(SENSORS, ACTUATORS)
    ]
