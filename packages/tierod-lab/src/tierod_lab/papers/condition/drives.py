"""Drives of the demonstrator: for calibration, fault-free, the tests of the paper, and further faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Annotated

from tierod_lab.papers.condition.faults import (
    DELAY,
    DRIFT,
    GAIN,
    LOSS,
    NOISE,
    OFFSET,
    OFFSETS,
    OUTLIER,
    OUTLIER_FACTOR,
    STUCK,
    Injected,
    lost,
)
from tierod_lab.papers.condition.vehicles import LATER, LONG, SHORT, THIRD, Vehicle, changed, vehicle

SENSORS = tuple(OFFSETS)
"""Sensors into which faults are injected."""
ACTUATORS = ("steering_motor_1", "steering_motor_2", "drive_left", "drive_right")
"""Actuators into which faults are injected."""

TEST_SECONDS, ACTUATOR_SECONDS = 60.0, 200.0
"""Duration of the paper's tests of sensors and of actuators [s]."""
LEG = 600.0
"""Longest duration of a single drive [s]."""
UNSEEN = 1000
"""First number of the random rounds that no calibration uses."""


@dataclass(frozen=True)
class Drive:
    """One drive to be recorded.

    Args:
        course: name of a course, see `vehicles.course`
        seconds: duration
        vehicle: number of the demonstrator, see `vehicles.vehicle`
        seed: seed of sensor noise, slopes and wind
        injected: injected faults
        swing: whether the split of the steering torque alternates
        later: property that has changed since the calibration, and its factor, see `vehicles.changed`
    """

    course: str
    seconds: Annotated[float, "s"]
    vehicle: int = 1
    seed: int = 0
    injected: tuple[Injected, ...] = ()
    swing: bool = True
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
        vehicle: number of the demonstrator
        swing: see `Drive`
    """
    first = Drive("round-0", 300.0, vehicle, 900 + vehicle, (), swing)
    hour = tuple(Drive(f"round-{leg + 1}", LEG, vehicle, 910 + 10 * vehicle + leg, (), swing) for leg in range(6))
    return first, hour


def healthy_drives(hours: float, vehicles: Sequence[int] = (1, 2, 3), swing: bool = True) -> list[Drive]:
    """Fault-free drives on rounds that no calibration uses, ten minutes each, with the vehicles in turn.

    Args:
        hours: total duration [h]
        vehicles: numbers of the demonstrators
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
        vehicles: numbers of the demonstrators
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
        vehicle: number of the demonstrator
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
        vehicle: number of the demonstrator
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
        vehicle: number of the demonstrator
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
        vehicle: number of the demonstrator
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
