"""Recordings of two real cars, and faults put into them, judged by the bank of filters of their motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.limits import sampled
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.signals import hypotheses_of_cars
from tierod.vehicles import Vehicle, load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import LOSS, OFFSET, OFFSETS, OUTLIER, Drive, Injected
from tierod_lab.papers.condition.scoring import KNOWN, Declared, Truth, declared_of, scored
from tierod_lab.papers.real_data import recorded
from tierod_lab.studies.metrics import Row

SENSORS = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle")
"""Judged sensors that production cars have."""

SETTLED = 2.0  # Warm-up at the start of a recording, which is not used [s]


@dataclass(frozen=True)
class RealCar:
    """A recording of a real car."""

    name: str  # name of the car for tables
    file: tuple[str, str]  # folder and file name of the recording
    vehicle: str  # name of its vehicle file
    dbc: str | None  # bus database, if the recording needs one
    # duration of the first part, on which limits, noises and accuracies were determined; the rest is judged
    learning: Annotated[float, "s"]
    starts: tuple[float, ...]  # beginnings of the injected faults on the clock of the recording [s]
    lasting: Annotated[float, "s"]  # duration of each fault

    @property
    def known(self) -> Vehicle:
        """Vehicle file of the car."""
        return load(self.vehicle)

    def recording(self) -> Recording | None:
        """The original recording; None where it or the library of its reader is missing."""
        return recorded(*self.file, dbc=self.dbc, channel_map=self.known.channel_map)


CARS = (
    RealCar("RAV4", ("rav4_highway_minute", "can.log"), "rav4", "rav4", 30.0, (33.0, 42.0, 51.0), 6.0),
    RealCar("passenger car", ("revsted_slip_angle", "obd.csv"), "revsted-car", None, 9.0, (10.0, 13.5, 17.0), 2.0),
)
"""The recordings: a minute of highway at 8 to 20 m/s, and 20 s of tight bends at 3 to 10 m/s."""


def accuracy(car: RealCar, recording: Recording) -> dict[str, float]:
    """Accuracy with which the other sensors of a car estimate each reading [unit of the sensor].

    It is the root mean square error of the filter that leaves the sensor out, on the learning part of the recording.
    """
    samples, base = sampled(recording), RollingFilter.of_vehicle(car.known)
    since, found = samples.time - samples.time[0], {}
    for each in hypotheses_of_cars():
        if len(each.sensors) == 1 and each.sensors[0] in SENSORS:
            (name,) = each.sensors
            reading = samples.values[:, samples.names.index(name)]
            error = reading - scan(base.leaving_out(each), samples.values)[f"prediction.{name}"]
            looked_at = (since >= SETTLED) & (since < car.learning) & np.isfinite(error)
            found[name] = float(np.sqrt(np.mean(error[looked_at] ** 2)))
    return found


def faults_of(sensor: str, start: float, lasting: float) -> tuple[Injected, ...]:
    """The faults of the tests for one sensor.

    Args:
        start: beginning of the faults on the clock of the recording [s]
        lasting: duration of all but the outlier, which lasts for a second [s]
    """
    end, size = start + lasting, OFFSETS[sensor]
    return (
        Injected(sensor, LOSS, start=start, end=end),
        Injected(sensor, OFFSET, size, start, end),
        Injected(sensor, OFFSET, -size, start, end),
        Injected(sensor, OUTLIER, 3.0, start, start + 1.0),
    )


def judged(
    car: RealCar, quick: bool = False, kinds: Callable[[str, float, float], tuple[Injected, ...]] = faults_of
) -> list[Row]:
    """Rows of a recording after its learning part, unchanged and with every injected fault; none without a recording.

    Args:
        quick: whether each fault is injected at one instant only
        kinds: function that gives the faults of a sensor from its name, start [s] and duration [s]
    """
    recording = car.recording()
    if recording is None:
        return []
    bank, own = rolling_monitor(car.known), accuracy(car, recording)
    less = {name: max(own[name], KNOWN[name]) for name in SENSORS}
    starts = car.starts[:1] if quick else car.starts
    chosen = [each for start in starts for sensor in SENSORS for each in kinds(sensor, start, car.lasting)]
    rows: list[Row] = []
    for faults in [(), *((each,) for each in chosen)]:
        samples = sampled(injected(recording, [each.fault for each in faults]))
        declared = declared_of(scan(bank, samples.values), samples.time)
        row = {"car": car.name, **_scored(car, recording, declared, faults, less)}
        if faults:
            row["missed_own"] = _scored(car, recording, declared, faults, own)["missed"]
        rows.append(row)
    return rows


def _scored(
    car: RealCar, whole: Recording, declared: Declared, faults: tuple[Injected, ...], known: Mapping[str, float]
) -> Row:
    """Row after the learning part; the unchanged recording is the truth."""
    time = declared.time
    judged_from = int(np.searchsorted(time, time[0] + car.learning))
    read = {each.element: np.interp(time, whole[each.element].time, whole[each.element].values) for each in faults}
    off = {}
    for each in faults:
        alone = Recording({each.element: Channel(each.element, time, read[each.element], "")})
        off[each.element] = injected(alone, [each.fault])[each.element].values - read[each.element]
    truth = Truth(
        {name: each[judged_from:] for name, each in off.items()},
        {name: each[judged_from:] for name, each in read.items()},
        known,
    )
    # A label for the score; nothing is simulated.
    drive = Drive(car.name, float(time[-1]), 0, 0, faults)
    return scored(drive, truth, declared.since(judged_from))[0]
