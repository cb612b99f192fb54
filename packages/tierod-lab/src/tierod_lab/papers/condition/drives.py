"""The demonstrator, its drives, and the faults that are put into them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, product
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.fields import numbers, replaced
from tierod.monitors.condition.signals import ACTUATORS, OF_AUTOMATED, TARGETS
from tierod_lab.ground.cars.road_cars import DemonstratorCar
from tierod_lab.ground.courses import AnyCourse, load
from tierod_lab.ground.courses.roads import Circuit, drawn, weather
from tierod_lab.ground.drivers import Split
from tierod_lab.ground.faults import Delay, Drift, Fault, Gain, Noise, Offset, Outlier, Stuck, TorqueLoss, TotalLoss
from tierod_lab.ground.faults.fault import AtTime
from tierod_lab.ground.sensors import SensorSet

SHORT, LONG, THIRD = "short-round", "long-round", "third-round"
"""Rounds of the tests, similar to Figures 18, 19 and 24 of Li, Frey, Gauterin."""

SENSORS = OF_AUTOMATED  # Sensors into which faults are injected

TORQUES = dict(
    zip(
        ACTUATORS,
        ("steering_motor_1_torque", "steering_motor_2_torque", "drive_torque_left", "drive_torque_right"),
        strict=True,
    )
)
"""Actuator -> channel of its torque."""

ASKED = dict(zip(ACTUATORS, TARGETS, strict=True))  # Actuator -> channel of its commanded torque

MEASURED = (
    *SENSORS,
    "longitudinal_acceleration",
    "lateral_acceleration",
    *TARGETS,
    "target_steering_wheel_angle",
    "target_vehicle_speed",
)
"""Channels that the demonstrator records for its monitor, at 100 Hz each."""

SWING = Split(share=0.5, swing=0.15, period=0.24)
"""Split of the steering torque that makes the motors isolable: 65 to 35 and back every 0.12 s."""

OFF = {
    ("chassis.mass", "chassis.yaw_inertia"): (0.04, 0.08),
    ("chassis.front.tyre.cornering_stiffness",): (0.05, 0.10),
    ("chassis.rear.tyre.cornering_stiffness",): (0.05, 0.10),
    ("steering.rack.friction.level",): (0.05, 0.20),
    ("steering.rack.rack_damping",): (0.05, 0.20),
    ("steering.rack.centring",): (0.05, 0.20),
}
"""Range of the relative deviation from the nominal vehicle, of either sign; fields of one key share a draw.

Source: mass and stiffness as in the richer simulations beside Li, Frey, Gauterin; friction, damping and centring are
assumed.
"""

RADIUS, SIDES = (0.025, 0.05), 0.006
"""Range of the relative deviation of all tyre radii, and largest difference between left and right [-]."""

BIASES = {
    "yaw_rate": 0.003,
    "steering_wheel_angle": 0.02,
    "steering_shaft_torque": 0.05,
    "tie_rod_force": 15.0,
    "longitudinal_acceleration": 0.05,
    "lateral_acceleration": 0.08,
}
"""Standard deviation of the constant offset of every sensor, in the unit of its signal; as of production sensors."""

LATER = {
    "mass": ("chassis.mass", "chassis.yaw_inertia"),
    "stiffness": ("chassis.front.tyre.cornering_stiffness", "chassis.rear.tyre.cornering_stiffness"),
    "radius": ("chassis.front.tyre.radius", "chassis.rear.tyre.radius"),
}
"""Property that may change after a calibration (load, tyres, tyre pressure) -> fields of the vehicle."""


class Vehicle(NamedTuple):
    """A demonstrator and its sensors."""

    car: DemonstratorCar
    sensors: SensorSet


@lru_cache(maxsize=64)
def course(name: str, seconds: float, seed: int = 0) -> AnyCourse:
    """A shipped course or a random round, a round with weather and slopes.

    Args:
        name: name of a shipped course, or "round-17" for a random round
        seconds: duration of the drive on a round [s]
        seed: seed of slopes, unevenness and wind; the path depends on the name alone
    """
    way = drawn(int(name.removeprefix("round-"))) if name.startswith("round-") else load(name)
    if not isinstance(way, Circuit):
        return way
    return replace(way, time=seconds, seed=seed, conditions=(*way.conditions, *weather(seed, way.length)))


def changed(of: Vehicle, what: str, factor: float) -> Vehicle:
    """A vehicle with a property of `LATER` that has changed since its calibration."""
    known = numbers(of.car)
    car = replaced(of.car, {path: factor * known[path].value for path in LATER[what]})
    if what != "radius":
        return Vehicle(car, of.sensors)
    # The wheel speeds are still computed with the former radius, so they read low on larger tyres.
    gains = {f"sensors.{name}.gain": of.sensors[name].gain / factor for name in SENSORS[:2]}
    return Vehicle(car, replaced(of.sensors, gains))


@lru_cache(maxsize=32)
def vehicle(number: int, swing: bool = True) -> Vehicle:
    """A demonstrator that deviates at random from the nominal one.

    Args:
        number: 0 for the nominal one with production sensors; any other is the seed of the deviations
        swing: whether the split of the steering torque between both motors alternates
    """
    car, sensors = DemonstratorCar(), SensorSet.production().only(MEASURED)
    if swing:
        car = replace(car, driver=replace(car.driver, split=SWING))
    if number == 0:
        return Vehicle(car, sensors)
    chance = np.random.default_rng([number, 611])

    def signed(band: tuple[float, float]) -> float:
        return float(chance.choice((-1.0, 1.0)) * chance.uniform(*band))

    known = numbers(car)
    changes: dict[str, float] = {}
    for paths, band in OFF.items():
        factor = 1.0 + signed(band)
        changes |= {path: known[path].value * factor for path in paths}
    common, sides = signed(RADIUS), signed((0.5 * SIDES, SIDES))
    changes |= {path: known[path].value * (1.0 + common) for path in LATER["radius"]}
    wrong = {
        f"{name}.gain": 1.0 / (1.0 + common + 0.5 * side) for name, side in zip(SENSORS, (sides, -sides), strict=False)
    }
    wrong |= {f"{name}.bias": deviation * float(chance.standard_normal()) for name, deviation in BIASES.items()}
    sensors = replaced(sensors, {f"sensors.{path}": value for path, value in wrong.items()})
    return Vehicle(replaced(car, changes), sensors)


LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY = KINDS = (
    *("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay"),
)
"""Kinds of sensor faults; an actuator has losses only."""

OFFSETS = dict(zip(SENSORS, (2.0, 2.0, 0.3, 1.5, 3.0, 250.0), strict=True))
"""Offset of every sensor in the tests, in the unit of its signal; the paper prints none."""

_BEHAVIOURS: dict[str, Any] = {
    OFFSET: Offset,
    GAIN: Gain,
    DRIFT: Drift,
    OUTLIER: Outlier,
    NOISE: Noise,
    DELAY: Delay,
    LOSS: lambda size: TotalLoss(),
    STUCK: lambda size: Stuck(),
}


@dataclass(frozen=True)
class Injected:
    """One injected fault of a drive, the truth for its score."""

    element: str  # signal of a sensor, or name of an actuator ("steering_motor_1")
    kind: str  # one of `KINDS`
    # fault magnitude: offset in the unit of the signal, factor of a gain or outlier, drift per second, standard
    # deviation of noise, delay in seconds, lost share of an actuator's torque; NaN for a kind without one
    size: float = math.nan
    start: Annotated[float, "s"] = 20.0
    end: Annotated[float, "s"] = 40.0

    @property
    def fault(self) -> Fault:
        """The fault as an object of the proving ground."""
        lasts, trigger = self.end - self.start, AtTime(self.start)
        if self.element in TORQUES:
            return Fault(f"actuator.{TORQUES[self.element]}", TorqueLoss(self.size), trigger, lasts)
        return Fault(f"sensor.{self.element}", _BEHAVIOURS[self.kind](self.size), trigger, lasts)


def lost(actuator: str, share: float = 1.0, start: float = 104.0, end: float = 200.0) -> Injected:
    """A lost share of the torque of an actuator; by default in the time of Figures 12 to 17 of the paper."""
    return Injected(actuator, LOSS, share, start, end)


TEST_SECONDS, ACTUATOR_SECONDS = 60.0, 200.0  # Duration of the paper's tests of sensors and of actuators [s]
LEG = 600.0  # Longest duration of a single drive [s]
UNSEEN = 1000  # First number of the random rounds that no calibration uses


@dataclass(frozen=True)
class Drive:
    """One drive to be recorded."""

    course: str  # name of a course, see `course`
    seconds: Annotated[float, "s"]
    vehicle: int = 1  # number of the demonstrator, see `vehicle`
    seed: int = 0  # seed of sensor noise, slopes and wind
    injected: tuple[Injected, ...] = ()
    swing: bool = True  # whether the split of the steering torque alternates
    later: tuple[str, float] | None = None  # property that has changed since the calibration, and its factor

    @property
    def driven(self) -> Vehicle:
        """The demonstrator and its sensors, as changed since the calibration."""
        known = vehicle(self.vehicle, self.swing)
        return changed(known, *self.later) if self.later else known


def calibration_drives(vehicle: int = 1) -> tuple[Drive, tuple[Drive, ...]]:
    """Fault-free drives on random rounds: five minutes for the parameters, and an hour for the thresholds."""
    hour = tuple(Drive(f"round-{leg + 1}", LEG, vehicle, 910 + 10 * vehicle + leg) for leg in range(6))
    return Drive("round-0", 300.0, vehicle, 900 + vehicle), hour


def healthy_drives(hours: float, vehicles: Sequence[int] = (1, 2, 3), swing: bool = True) -> list[Drive]:
    """Fault-free drives on rounds that no calibration uses, ten minutes each, with the vehicles in turn."""
    count = max(round(hours * 3600.0 / LEG), 1)
    seconds = min(hours * 3600.0, LEG)
    first = 1000 * (vehicles[0] - 1)  # other demonstrators, other rounds
    return [
        Drive(f"round-{first + UNSEEN + leg}", seconds, vehicles[leg % len(vehicles)], first + 2000 + leg, (), swing)
        for leg in range(count)
    ]


def changed_drives(hours: float, vehicles: Sequence[int] = (1, 2, 3)) -> list[Drive]:
    """Fault-free drives of vehicles with a property of `LATER` that is 10 % more or less than at the calibration."""
    # A change stays for one turn of all vehicles, so that every vehicle gets every change.
    changes = [(what, 1.0 + sign * 0.1) for what in LATER for sign in (1.0, -1.0)]
    return [
        replace(each, seed=each.seed + 1000, later=changes[leg // len(vehicles) % len(changes)])
        for leg, each in enumerate(healthy_drives(hours, vehicles))
    ]


def sensor_tests(vehicle: int = 1, swing: bool = True) -> list[Drive]:
    """The 48 tests of the sensors: six sensors, four faults from 20 s on, short and long round.

    Source: Li, Frey, Gauterin, section 5: total loss, offset of either sign, and an outlier of one second.
    """
    return [
        Drive(course, TEST_SECONDS, vehicle, 10 + vehicle, (Injected(sensor, *fault),), swing)
        for sensor in SENSORS
        for fault in ((LOSS,), (OFFSET, OFFSETS[sensor]), (OFFSET, -OFFSETS[sensor]), (OUTLIER, 3.0, 20.0, 21.0))
        for course in (SHORT, LONG)
    ]


def actuator_tests(vehicle: int = 1, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """The nine tests of the actuators: either steering motor or one drive lost, on three rounds.

    The paper has three losses on each of three rounds, but does not list them. Here the right drive fails on the long
    round, the left one on the two others.
    """
    drives = {SHORT: "drive_left", LONG: "drive_right", THIRD: "drive_left"}
    return [
        Drive(course, ACTUATOR_SECONDS, vehicle, 20 + vehicle, (lost(actuator, share),), swing)
        for course, drive in drives.items()
        for actuator in (*ACTUATORS[:2], drive)
    ]


def supply_tests(vehicle: int = 1, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """Tests with a common cause, such as a lost supply: both steering motors or both drives lost, on three rounds."""
    return [
        Drive(course, ACTUATOR_SECONDS, vehicle, 20 + vehicle, tuple(lost(name, share) for name in pair), swing)
        for course in (SHORT, LONG, THIRD)
        for pair in (ACTUATORS[:2], ACTUATORS[2:])
    ]


def more_kinds(vehicle: int = 1, course: str = SHORT, seed: int = 0, sizes: Sequence[float] = (1.0,)) -> list[Drive]:
    """Drives with every kind of fault of every sensor, in several sizes.

    Args:
        sizes: multiples of the offset of the tests; the other kinds are scaled to disturb the reading as much
    """
    drives = []
    for sensor, size in product(SENSORS, sizes):
        amount = size * OFFSETS[sensor]
        faults: list[tuple[Any, ...]] = [
            *((OFFSET, amount), (OFFSET, -amount), (GAIN, 1.0 + 0.5 * size), (GAIN, 1.0 / (1.0 + 0.5 * size))),
            *((DRIFT, 0.1 * amount), (NOISE, 0.5 * amount), (DELAY, 0.2 * size)),
            *(((LOSS,), (STUCK,), (OUTLIER, 3.0, 20.0, 21.0)) if size == 1.0 else ()),
        ]
        drives += [Drive(course, TEST_SECONDS, vehicle, seed, (Injected(sensor, *each),)) for each in faults]
    return drives


def pairs(vehicle: int = 1, course: str = SHORT, seed: int = 0) -> list[Drive]:
    """Drives with two faults, the second 2 s later: two sensors, both lost or off, and a sensor with an actuator."""
    several = [
        *(
            (
                Injected(first, kind, sizes.get(first, math.nan)),
                Injected(second, kind, sizes.get(second, math.nan), 22.0),
            )
            for first, second in combinations(SENSORS, 2)
            for kind, sizes in ((LOSS, {}), (OFFSET, OFFSETS))
        ),
        *(
            (Injected(sensor, OFFSET, OFFSETS[sensor]), lost(actuator, share, 22.0, 40.0))
            for share in (1.0, 0.5)
            for sensor, actuator in product(SENSORS, ACTUATORS)
        ),
    ]
    return [Drive(course, TEST_SECONDS, vehicle, seed, pair) for pair in several]
