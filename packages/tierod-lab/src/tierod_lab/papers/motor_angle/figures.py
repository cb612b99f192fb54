"""Figures 4 to 7 of the paper: the observers in a car with active front steering, and on the bench."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.graph import Result, scan
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.motor_angle.fault_drives import RATE
from tierod_lab.papers.motor_angle.observer_drives import Accuracy, accuracy, methods, rms, to_and_fro
from tierod_lab.papers.motor_angle.reported import IN_THE_CAR, SEEDS, SIDE_BY_SIDE
from tierod_lab.studies.effort import Effort

CAR = "active-front-steering"
"""Name of the car, and of its vehicle file."""


@dataclass(frozen=True)
class CarDrive:
    """A drive of the car, with the truth every ten milliseconds.

    Args:
        samples: signals of `MotorAngleObserver.Sample` at `RATE`, (n, 5)
        places: indices of the samples with a true value, (m,)
        angle, speed: true angle and speed of the motor shaft [rad], [rad/s], (m,)
    """

    samples: np.ndarray
    places: np.ndarray
    angle: np.ndarray
    speed: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Time of the true values from the first sample [s]."""
        return self.places / RATE

    def observed(self, observer: Block) -> Result:
        """Outputs of an observer."""
        return scan(observer, self.samples)

    def error(self, observer: Block) -> np.ndarray:
        """Error of an observer's angle at the samples with a true value [rad]."""
        return np.asarray(self.observed(observer)["motor_angle"][self.places] - self.angle)


@lru_cache(maxsize=8)
def car_drive(course: str, seconds: float, seed: int = 1) -> CarDrive:
    """Simulate a drive with the sensors of a production car, with the motor angle sampled at `RATE`.

    Args:
        course: name of a course of the proving ground
        seconds: duration [s]
        seed: seed of all random numbers
    """
    sensors = SensorSet.production()
    angle = replace(dict(sensors.items())["motor_angle_mechanical"], rate=RATE)
    sensors = sensors.with_sensors({"motor_angle_mechanical": angle})
    channels = run(catalogue.load(CAR).block, courses.load(course), seconds, seed, sensors).recording.channels
    samples = np.column_stack([channels[name].values for name in MotorAngleObserver.Sample._fields])
    truth = channels["truth_motor_angle_mechanical"]
    places = np.round(truth.time * RATE).astype(int)
    # A last true value may lie beyond the last sample of the observer.
    kept = places < len(samples)
    return CarDrive(samples, places[kept], truth.values[kept], channels["truth_motor_speed"].values[kept])


PRINTED = (
    "Luenberger, as printed",
    "reduced Luenberger, as printed",
    "Kalman filter, as printed",
    "feedforward, held when slow",
)
"""The four methods of the paper."""
FOLLOWS = 0.1
"""Largest error of an observer that follows "pretty well" [rad]: the scale of Figures 4 and 5 would hide it."""
LOADED = (
    "Luenberger, with load",
    "reduced Luenberger, with load",
    "Kalman filter, with load",
    "feedforward, increments, with load",
    "flux observer",
    "default",
)
"""The same methods with the load as a state, and methods that the paper does not contain."""
FAST, HELD = (18.0, 20.5), (22.2, 27.8)
"""Intervals of the parking manoeuvre: steering from lock to lock, and holding near a lock [s]."""
EVERY = 4
"""Decimation of the drawn curves [true values]."""


def items(effort: Effort) -> Iterator[Item]:
    slalom = car_drive("slalom", 12.0 if effort.quick else 30.0, SEEDS.of(IN_THE_CAR, 2)[0])
    parking = car_drive("parking", 30.0 if effort.quick else 40.0, SEEDS.of(IN_THE_CAR, 2)[1])
    yield Heading(
        "In the car (Figures 4 to 7)",
        (
            "The virtual car with active front steering and a motor under control of its current drives a slalom and "
            "parks, with the noise of a production car's sensors. The methods as printed have their misprints "
            "corrected, but no load; the paper shows a drive of a prototype without numbers.",
            "In the paper the observers follow well and the feedforward keeps offsets. Here the observers without load "
            "lose the angle at once, since the gear loads the motor all the time; with the load they follow.",
        ),
    )
    observers = methods(CAR)
    errors = {
        drive: {name: seen.error(each) for name, each in observers.items()} for drive, seen in _named(slalom, parking)
    }
    yield _table(errors, effort)
    yield _whole("motor-angle-figure-4", "Slalom (Figure 4)", slalom, errors["slalom"])
    yield _whole("motor-angle-figure-5", "Parking (Figure 5)", parking, errors["parking"])
    yield _section("motor-angle-figure-6", "From lock to lock (Figure 6)", parking, errors["parking"], FAST)
    yield _section("motor-angle-figure-7", "Held near the lock (Figure 7)", parking, errors["parking"], HELD)
    yield from _paper_claims(parking, errors)
    yield from _own_claims(slalom, parking, errors)


def _named(slalom: CarDrive, parking: CarDrive) -> tuple[tuple[str, CarDrive], ...]:
    return ("slalom", slalom), ("parking", parking)


def _table(errors: dict[str, dict[str, np.ndarray]], effort: Effort) -> Table:
    bench = [
        to_and_fro(seed, 6.0 if effort.quick else 20.0) for seed in SEEDS.of(SIDE_BY_SIDE, 1 if effort.quick else 3)
    ]
    beside = {name: accuracy(observer, bench) for name, observer in methods().items()}

    def cells(each: Accuracy) -> tuple[str, str]:
        return f"{each.angle:.4f}", f"{each.largest:.3f}"

    rows = tuple(
        (name, *(cell for drive in errors.values() for cell in _cells(drive[name])), *cells(beside[name]))
        for name in beside
    )
    header = ("observer", *(f"{name}, {what}" for name in (*errors, "bench") for what in ("rms", "most")))
    return Table("Error of the motor's angle in the car and on the bench (rad)", header, rows)


def _cells(error: np.ndarray) -> tuple[str, str]:
    return f"{rms(error):.4f}", f"{np.abs(error).max():.3f}"


def _whole(name: str, title: str, seen: CarDrive, errors: dict[str, np.ndarray]) -> Chart:
    kept = slice(None, None, EVERY)
    measured = Lines("measured", seen.time[kept], seen.samples[seen.places, 4][kept])
    printed = [Lines(each, seen.time[kept], (seen.angle + errors[each])[kept], dashed=True) for each in PRINTED]
    loaded = [Lines(each, seen.time[kept], errors[each][kept]) for each in LOADED]
    return Chart(
        name,
        title,
        "Above: angle of the motor as measured and by the four methods of the paper. Below: errors with the load as a "
        "state, and of the methods that the paper does not have.",
        "Without load the observers leave the measured angle; with load they stay near it, the default nearest.",
        (
            Panel("", "time (s)", "angle (rad)", (measured, *printed)),
            Panel("", "time (s)", "error of the angle (rad)", tuple(loaded)),
        ),
    )


def _section(name: str, title: str, seen: CarDrive, errors: dict[str, np.ndarray], span: tuple[float, float]) -> Chart:
    part = (seen.time >= span[0]) & (seen.time <= span[1])
    time, first = seen.time[part], int(np.argmax(part))
    measured = Lines("measured", time, seen.samples[seen.places, 4][part])
    lines: list[Lines] = [
        Lines(each, time, (seen.angle + errors[each])[part] - errors[each][first], dashed=True)
        for each in (*PRINTED, "default")
    ]
    changes = [Lines(each, time, errors[each][part] - errors[each][first]) for each in (*PRINTED, *LOADED)]
    return Chart(
        name,
        title,
        "Every method begins the section at the true angle, so that what it loses there is seen. Below: what it loses.",
        "What each method loses while the motor turns fast, or stands.",
        (
            Panel("", "time (s)", "angle (rad)", (measured, *lines)),
            Panel("", "time (s)", "lost angle (rad)", tuple(changes)),
        ),
    )


def _paper_claims(parking: CarDrive, errors: dict[str, dict[str, np.ndarray]]) -> Iterator[Claim]:
    paper = "Reinelt et al., Results"
    observers = PRINTED[:3]
    yield Claim(
        "car.observers-follow",
        "The observers follow the overall dynamics: worst error of the printed three in the slalom, root mean square.",
        f"{paper}, Figures 4 and 5",
        "pretty well",
        max(rms(errors["slalom"][name]) for name in observers),
        at_most(FOLLOWS),
        "rad",
        "They do not, under load: they know none, and integrate the speed that it costs. With the load as a state they "
        "do. The paper prints no figure, and plots some seconds.",
        cause="The paper prints neither load, parameters nor duration, and its equations know no load: without one "
        "they err by a speed per load that follows from their gains, see the first claims. The same observers with "
        f"the load as a state: {max(rms(errors['slalom'][each]) for each in LOADED[:3]):.3f} rad.",
        irreproducible=True,
    )
    name, speed = "feedforward, held when slow", np.abs(parking.speed)
    fast, slow = (rms(errors["parking"][name][part]) for part in (speed > 40.0, (speed > 6.0) & (speed < 20.0)))
    yield Claim(
        "car.feedforward-fast",
        "The feedforward keeps better track at higher speeds: its error above 40 over that from 6 to 20 rad/s.",
        f"{paper}, Figure 6",
        None,
        fast / slow,
        at_most(1.0),
        "",
        "Below 1 on one drive of the car, 2 on another: an integrated angle keeps what it lost, whatever the speed.",
        cause="The paper plots one drive that it does not print, and gives no figure. On this one the error is "
        f"{fast:.2f} rad above 40 and {slow:.2f} rad from 6 to 20 rad/s. (46) gives an angle within half a turn only; "
        "which half turn, and the hold of a motor that stands, are added here.",
        irreproducible=True,
    )
    lost = {name: _lost(parking, errors["parking"][name], HELD) for name in observers}
    yield Claim(
        "car.standing-offset",
        "Observers whose state is a speed lose the angle while the motor stands: the least of the printed three.",
        f"{paper}, Figure 7",
        None,
        min(lost.values()),
        at_least(0.05),
        "rad",
        "over 5.6 s near the lock, under holding torque",
    )


def _own_claims(slalom: CarDrive, parking: CarDrive, errors: dict[str, dict[str, np.ndarray]]) -> Iterator[Claim]:
    gain = [
        rms(errors["slalom"][f"{name}, as printed"]) / rms(errors["slalom"][f"{name}, with load"])
        for name in ("Luenberger", "reduced Luenberger", "Kalman filter")
    ]
    yield Claim(
        "car.load",
        "With the load as a state the observers follow in the car too: printed error over that, least of three.",
        "tierod",
        None,
        min(gain),
        at_least(10.0),
    )
    yield Claim(
        "car.standing-default",
        "The default does not.",
        "target of tierod",
        None,
        _lost(parking, errors["parking"]["default"], HELD),
        at_most(0.001),
        "rad",
    )
    worst = max(rms(each["default"]) for each in errors.values())
    yield Claim(
        "car.default",
        "Error of the default in the car, root mean square of the worse drive.",
        "target of tierod",
        None,
        worst,
        at_most(0.006),
        "rad",
        f"{slalom.samples.shape[0] / RATE:g} s of slalom, {parking.samples.shape[0] / RATE:g} s of parking",
    )


def _lost(seen: CarDrive, error: np.ndarray, span: tuple[float, float]) -> float:
    """Change of the error over an interval, from means over half a second at either end [rad]."""
    begin, end = ((seen.time >= edge) & (seen.time < edge + 0.5) for edge in (span[0], span[1] - 0.5))
    return abs(float(error[end].mean() - error[begin].mean()))
