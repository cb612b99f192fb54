"""One unknown car: identified from one drive, and its other drives judged with three vehicle files."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Diagnosis
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.methods.identification.experiment import Found
from tierod.monitors.diagnose import OverTime
from tierod.monitors.own_car import identify_own_car
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.vehicles.vehicle import Vehicle
from tierod_lab.ground import run
from tierod_lab.ground.courses.course import Restlessness
from tierod_lab.ground.courses.roads import NaturalDrive
from tierod_lab.papers.own_car.brochure import identified
from tierod_lab.papers.own_car.cars import UnknownCar, drawn

TRUTHS = {
    "sideslip": "truth_sideslip_angle",
    "driver-torque": "truth_hand_torque",
    "friction": "truth_friction_torque",
    "condition": "",
}
"""Monitors for ordinary drives, with the channel of the true value of the estimate; "" for one without an estimate."""

ESTIMATES = {"sideslip": "sideslip_angle", "driver-torque": "hand_torque", "friction": "friction_torque"}
"""Trace of the estimate of each monitor."""

ON_BUS = (
    *("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "yaw_rate"),
    *("lateral_acceleration", "longitudinal_acceleration", "vehicle_speed"),
    *("wheel_speed_front_left", "wheel_speed_front_right", "wheel_speed_rear_left", "wheel_speed_rear_right"),
)
"""Signals on the bus of a production car."""

BROCHURE, IDENTIFIED, TRUE = "brochure", "identified", "true"  # Names of the three vehicle files
STATED_FOR = "reference_load_Nm"
"""Evidence of the friction monitor that holds the load to which its estimate refers [N*m]."""
SETTLED = 60.0  # Warm-up at the start of a drive, in which the estimate is not compared [s]
APART = 0.2  # Interval between compared samples [s]
FALSE = (Status.FAULT, Status.RISING)  # Verdicts that count as false on a fault-free drive


@dataclass(frozen=True)
class Case:
    """A car to be judged, and the length of its drives."""

    number: int  # number of the car
    seed: int  # seed of all random numbers
    learning: float  # duration of the drive that identifies the car [min]; 0 omits the identification
    minutes: float  # duration of each judged drive [min]
    drives: int  # number of judged drives
    measured: bool = False  # whether the processor time of the spread is measured on the first one


class Judged(NamedTuple):
    """Result of one monitor on one drive with one vehicle file."""

    car: str  # car, monitor, file: names of car, monitor and vehicle file
    monitor: str
    file: str
    status: Status  # status of the finding
    headline: str  # headline of the finding
    # samples, held: number of samples compared with the truth, and of those with the truth in the 95 % band
    samples: int
    held: int
    squares: float  # sum of squared errors, in SI units
    cost: float  # processor time with the spread over that without; NaN where not measured


class Studied(NamedTuple):
    """All results of one car."""

    judged: tuple[Judged, ...]  # every monitor on every drive with every file
    learnt: tuple[str, ...]  # names of the identified parameters; empty where the identification reports a doubt
    # whether the 95 % interval of an identified parameter holds the true value, where there is one
    within: tuple[bool, ...]
    doubt: str  # reason why nothing was identified; empty otherwise
    seconds: float  # duration of the identification [s]


def studied(case: Case) -> Studied:
    """Draw an unknown car, identify it, and judge its other drives.

    Args:
        case: the car, and the length of its drives
    """
    car = drawn(case.number, case.seed)
    files = {BROCHURE: car.brochure, TRUE: car.true}
    learnt: tuple[str, ...] = ()
    within: tuple[bool, ...] = ()
    doubt, seconds = "", 0.0
    if case.learning:
        before = time.perf_counter()
        bare = without_truth(driven(car, case.learning, 100 * case.seed))
        found = identify_own_car({"learning": bare}, car.brochure)
        seconds, doubt = time.perf_counter() - before, found.doubt
        if not doubt:
            learnt, within = tuple(each.name for each in found.found), tuple(_within(car.true, found.found))
        files[IDENTIFIED] = identified(car.brochure, found)
    judged: list[Judged] = []
    for place in range(case.drives):
        recording = driven(car, case.minutes, 100 * case.seed + 1 + place)
        bare = without_truth(recording)
        for file, vehicle in files.items():
            judged += verdicts(car, file, vehicle, bare, recording, case.measured and not place and file == BROCHURE)
    return Studied(tuple(judged), learnt, within, doubt, seconds)


def _within(true: Vehicle, found: Sequence[Found]) -> Iterator[bool]:
    """Whether the interval of an identified parameter holds the true value, for those that the plant has."""
    for each in found:
        known = true.parameters.get(each.name)
        if known is not None and known.standard_deviation == 0.0:
            yield each.low <= known.value <= each.high


def driven(car: UnknownCar, minutes: float, seed: int) -> Recording:
    """Simulate a fault-free drive through town, country and, where the car can, motorway.

    Args:
        minutes: duration [min]
    """
    course = NaturalDrive(name="own car", seed=seed, conditions=(Restlessness(),), roads=car.roads, time=60.0 * minutes)
    return run(car.block, course, seed=seed).recording


def without_truth(recording: Recording) -> Recording:
    """The recording reduced to the signals on the bus of a production car."""
    return Recording({name: recording[name] for name in ON_BUS if name in recording})


def verdicts(
    car: UnknownCar, file: str, vehicle: Vehicle, bare: Recording, whole: Recording, measured: bool = False
) -> Iterator[Judged]:
    """Judge a drive with every monitor that can run.

    Args:
        vehicle: its content, with which the drive is judged
        bare: the drive without true values
        measured: whether the processor time of the spread is measured
    """
    for monitor, truth in TRUTHS.items():
        try:
            found = over(monitor, vehicle, bare, uncertain=True)
            # The best of two runs of either kind leaves out the compilation of its kernel.
            cost = _cost(monitor, vehicle, bare) if measured else np.nan
        except (InputError, ParameterError):
            continue
        finding = found.diagnosis.findings[0]
        compared = (0, 0, 0.0)
        if truth and truth in whole:
            # Gear friction rises with the transmitted torque, and the monitor states it for one load.
            stated = finding.evidence.get(STATED_FOR)
            factor = 1.0 if stated is None else car.friction_over_level(stated)
            compared = _compared(found.traces, ESTIMATES[monitor], whole, truth, factor)
        yield Judged(car.name, monitor, file, finding.status, finding.headline, *compared, cost)


class Over(NamedTuple):
    """A diagnosis, and its estimates over time."""

    diagnosis: Diagnosis
    traces: Recording


def over(monitor: str, vehicle: Vehicle, recording: Recording, uncertain: bool) -> Over:
    """Run a monitor over a recording and keep its traces.

    Args:
        recording: the drive without true values
        uncertain: whether the spread of the parameters is propagated

    Raises:
        InputError: the recording lacks a required signal
        ParameterError: the vehicle lacks a required parameter
    """
    definition, variant = find(monitor)
    kept = OverTime()
    process = Run(definition, variant, vehicle, kept=kept.add, uncertain=uncertain)
    process.add(recording)
    diagnosis = process.finish()
    # Estimates that a report withholds count in the coverage as well.
    units = {**process.session.traces, **{name: trace.unit for name, trace in diagnosis.traces.items()}}
    return Over(diagnosis, kept.recording(units, monitor))


def _cost(monitor: str, vehicle: Vehicle, recording: Recording) -> float:
    """Ratio of processor times with and without the spread of the parameters, each the best of two runs."""
    seconds = []
    for uncertain in (True, False):
        each = []
        for _ in range(2):
            before = time.process_time()
            over(monitor, vehicle, recording, uncertain)
            each.append(time.process_time() - before)
        seconds.append(min(each))
    return seconds[0] / seconds[1]


def _compared(traces: Recording, name: str, whole: Recording, truth: str, factor: float) -> tuple[int, int, float]:
    """Compare an estimate with a factor times the truth: samples, those in the 95 % band, sum of squared errors."""
    deviation = f"{name}_standard_deviation"
    if name not in traces or deviation not in traces:
        return 0, 0, 0.0
    at = np.arange(traces[name].time[0] + SETTLED, traces[name].time[-1], APART)
    places = np.searchsorted(traces[name].time, at)
    value, spread = traces[name].values[places], traces[deviation].values[places]
    error = value - factor * np.interp(traces[name].time[places], whole[truth].time, whole[truth].values)
    moving = np.interp(at, whole["truth_speed"].time, whole["truth_speed"].values) > 1.5
    known = np.isfinite(error) & np.isfinite(spread) & moving
    held = np.abs(error[known]) <= 1.96 * spread[known]
    return int(known.sum()), int(held.sum()), float(np.sum(error[known] ** 2))
