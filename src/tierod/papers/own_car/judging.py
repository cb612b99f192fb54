"""One unknown car: identified from one drive, its other drives judged with three vehicle files."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.methods.identification.experiment import Found
from tierod.monitors.diagnose import find
from tierod.monitors.harness.over_time import OverTime
from tierod.monitors.harness.run import Run
from tierod.monitors.own_car import identify_own_car
from tierod.papers.own_car.brochure import identified
from tierod.papers.own_car.cars import UnknownCar, drawn
from tierod.proving_ground import run
from tierod.proving_ground.courses.conditions import Restlessness
from tierod.proving_ground.courses.natural import NaturalDrive
from tierod.vehicles.vehicle import Vehicle

TRUTHS = {
    "sideslip": "truth_sideslip_angle",
    "driver-torque": "truth_hand_torque",
    "friction": "truth_friction_torque",
    "condition": "",
}
"""Monitors that ordinary drives feed, and the channel of what each estimates; "" where it judges alone."""

ESTIMATES = {"sideslip": "sideslip_angle", "driver-torque": "hand_torque", "friction": "friction_torque"}
"""Their traces."""

ON_BUS = (
    *("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "yaw_rate"),
    *("lateral_acceleration", "longitudinal_acceleration", "vehicle_speed"),
    *("wheel_speed_front_left", "wheel_speed_front_right", "wheel_speed_rear_left", "wheel_speed_rear_right"),
)
"""What a production car gives."""

BROCHURE, IDENTIFIED, TRUE = "brochure", "identified", "true"
STATED_FOR = "reference_load_Nm"
"""Evidence of the friction monitor: the load for which it states friction."""
SETTLED = 60.0
"""Of a drive, from when on an estimate is compared [s]."""
APART = 0.2
"""Time between two samples that are compared [s]."""
FALSE = (Status.FAULT, Status.RISING)
"""Verdicts that a fault-free drive must not get."""


@dataclass(frozen=True)
class Case:
    """A car to be judged.

    Args:
        number: of the car
        seed: of all chance
        learning: drive from which it is identified [min]; 0 leaves that out
        minutes: of each drive that is judged
        drives: that are judged
        measured: whether the cost of the spread is measured on the first one
    """

    number: int
    seed: int
    learning: float
    minutes: float
    drives: int
    measured: bool = False


class Judged(NamedTuple):
    """One monitor on one drive with one vehicle file.

    Args:
        car, monitor, file: which
        status: of the finding
        headline: of the finding
        samples, held: compared with the truth, and how many of them lie in the 95 % band
        squares: sum of squared errors, in SI units
        cost: time with the spread over that without; NaN where not measured
    """

    car: str
    monitor: str
    file: str
    status: Status
    headline: str
    samples: int
    held: int
    squares: float
    cost: float


class Studied(NamedTuple):
    """All of one car.

    Args:
        judged: every monitor on every drive with every file
        learnt: parameters that were identified; empty where that left a doubt
        within: of each of them that has a true value, whether that lies in its 95 % interval
        doubt: why nothing was identified
        seconds: that the identification took
    """

    judged: tuple[Judged, ...]
    learnt: tuple[str, ...]
    within: tuple[bool, ...]
    doubt: str
    seconds: float


def studied(case: Case) -> Studied:
    """An unknown car from its brochure to its verdicts.

    Args:
        case: which car, and how much it drives
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
    """Whether the interval of an identified parameter holds the true value, of those that the plant has."""
    for each in found:
        known = true.parameters.get(each.name)
        if known is not None and known.standard_deviation == 0.0:
            yield each.low <= known.value <= each.high


def driven(car: UnknownCar, minutes: float, seed: int) -> Recording:
    """A fault-free drive through town, country and, where the car can, motorway.

    Args:
        car: that drives
        minutes: for so long
        seed: of route and sensors
    """
    course = NaturalDrive(name="own car", seed=seed, conditions=(Restlessness(),), roads=car.roads, time=60.0 * minutes)
    return run(car.block, course, seed=seed).recording


def without_truth(recording: Recording) -> Recording:
    """Recording of the signals that the bus of a production car carries."""
    return Recording({name: recording[name] for name in ON_BUS if name in recording})


def verdicts(
    car: UnknownCar, file: str, vehicle: Vehicle, bare: Recording, whole: Recording, measured: bool = False
) -> Iterator[Judged]:
    """Every monitor that can run.

    Args:
        car: that drove
        file: which vehicle file it is
        vehicle: as which the drive is judged
        bare: the drive without truth
        whole: the same with the truth
        measured: whether the cost of the spread is measured
    """
    for monitor, truth in TRUTHS.items():
        try:
            found = over(monitor, vehicle, bare, uncertain=True)
            # A second run of either kind has its kernel, and shows what it costs.
            cost = _cost(monitor, vehicle, bare) if measured else np.nan
        except (InputError, ParameterError):
            continue
        finding = found.diagnosis.findings[0]
        compared = (0, 0, 0.0)
        if truth and truth in whole:
            # Friction of a gear that is pressed by what it passes on is stated for one load.
            stated = finding.evidence.get(STATED_FOR)
            factor = 1.0 if stated is None else car.friction_over_level(stated)
            compared = _compared(found.traces, ESTIMATES[monitor], whole, truth, factor)
        yield Judged(car.name, monitor, file, finding.status, finding.headline, *compared, cost)


class Over(NamedTuple):
    """A diagnosis, and what it estimated over time."""

    diagnosis: Diagnosis
    traces: Recording


def over(monitor: str, vehicle: Vehicle, recording: Recording, uncertain: bool) -> Over:
    """A monitor over a recording.

    Args:
        monitor: its name
        vehicle: as which it is judged
        recording: without truth
        uncertain: whether the spread of the parameters is carried

    Raises:
        InputError: the recording lacks what the monitor needs
        ParameterError: the vehicle lacks it
    """
    definition, variant = find(monitor)
    kept = OverTime()
    whole = complete(recording, [*definition.required, *definition.optional])
    process = Run(definition.suited_to(whole), variant, vehicle, kept=kept, uncertain=uncertain)
    process.add(recording)
    diagnosis = process.finish()
    # What a report withholds is scored as well.
    units = {**process.session.traces, **{name: trace.unit for name, trace in diagnosis.traces.items()}}
    return Over(diagnosis, kept.recording(units, monitor))


def _cost(monitor: str, vehicle: Vehicle, recording: Recording) -> float:
    """Processor time with the spread over that without, best of two each."""
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
    """Samples compared with the truth times a factor, held by the 95 % band, and the sum of squared errors."""
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
