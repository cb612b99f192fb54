"""Unknown cars: identified from one drive, and their other drives judged with three vehicle files; real cars."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Diagnosis, Finding
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import OverTime, diagnose
from tierod.monitors.own_car import identify_own_car
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.vehicles import load
from tierod.vehicles.vehicle import Vehicle
from tierod_lab.ground import run
from tierod_lab.ground.courses.course import Restlessness
from tierod_lab.ground.courses.roads import NaturalDrive
from tierod_lab.papers.own_car.brochure import brochure_car, identified
from tierod_lab.papers.own_car.cars import UnknownCar, drawn
from tierod_lab.papers.real_data import recorded
from tierod_lab.studies.metrics import Row

TRUTHS = {
    "sideslip": ("sideslip_angle", "truth_sideslip_angle"),
    "driver-torque": ("hand_torque", "truth_hand_torque"),
    "friction": ("friction_torque", "truth_friction_torque"),
    "condition": ("", ""),
}
"""Monitors for ordinary drives, with the trace of the estimate and the channel of its true value."""

ON_BUS = (
    *("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "yaw_rate"),
    *("lateral_acceleration", "longitudinal_acceleration", "vehicle_speed"),
    *("wheel_speed_front_left", "wheel_speed_front_right", "wheel_speed_rear_left", "wheel_speed_rear_right"),
)
"""Signals on the bus of a production car."""

STATED_FOR = "reference_load_Nm"
"""Evidence of the friction monitor that holds the load to which its estimate refers [N*m]."""
SETTLED, APART = 60.0, 0.2  # Warm-up of a drive that is not compared, and interval between compared samples [s]
FALSE = (Status.FAULT, Status.RISING)  # Verdicts that count as false on a fault-free drive


@dataclass(frozen=True)
class Case:
    """A car to be judged, and the length of its drives."""

    number: int  # number of the car
    seed: int  # seed of all random numbers
    learning: float  # duration of the drive that identifies the car [min]; 0 omits the identification
    minutes: float  # duration of each judged drive [min]
    drives: int  # number of judged drives


def over_cars(case: Case) -> list[Row]:
    """Cars drawn over the classes, quadricycle to van, front and rear drive, column and rack EPS.

    Of each its user knows mass (to 5 %) and wheelbase; all else is typical of the class, with its spread, as `tierod
    new` writes it. One drive identifies the car, other drives are judged with the file before, the file after, and with
    the true parameters. No monitor sees a truth.
    """
    car = drawn(case.number, case.seed)
    files, rows = {"brochure": car.brochure, "true": car.true}, list[Row]()
    if case.learning:
        bare = without_truth(driven(car, case.learning, 100 * case.seed))
        found = identify_own_car({"learning": bare}, car.brochure)
        files["identified"] = identified(car.brochure, found)
        for each in [] if found.doubt else found.found:
            known = car.true.parameters.get(each.name)
            if known is not None and known.standard_deviation == 0.0:
                within = float(each.low <= known.value <= each.high)
                rows.append({"car": car.name, "monitor": "", "parameter": each.name, "within": within})
    for place in range(case.drives):
        recording = driven(car, case.minutes, 100 * case.seed + 1 + place)
        for file, vehicle in files.items():
            rows += _judged(car, file, vehicle, recording)
    return rows


def driven(car: UnknownCar, minutes: float, seed: int) -> Recording:
    """Simulate a fault-free drive through town, country and, where the car can, motorway."""
    course = NaturalDrive(name="own car", seed=seed, conditions=(Restlessness(),), roads=car.roads, time=60.0 * minutes)
    return run(car.block, course, seed=seed).recording


def without_truth(recording: Recording) -> Recording:
    """The recording reduced to the signals on the bus of a production car."""
    return Recording({name: recording[name] for name in ON_BUS if name in recording})


def _judged(car: UnknownCar, file: str, vehicle: Vehicle, whole: Recording) -> Iterator[Row]:
    """A row of every monitor that can run."""
    bare = without_truth(whole)
    for monitor, (name, truth) in TRUTHS.items():
        try:
            found = over(monitor, vehicle, bare)
        except (InputError, ParameterError):
            continue
        finding = found.diagnosis.findings[0]
        compared: Row = {}
        if truth in whole and name in found.traces and f"{name}_standard_deviation" in found.traces:
            traces = found.traces
            # Gear friction rises with the transmitted torque, and the monitor states it for one load.
            stated = finding.evidence.get(STATED_FOR)
            factor = 1.0 if stated is None else car.friction_over_level(stated)
            at = np.arange(traces[name].time[0] + SETTLED, traces[name].time[-1], APART)
            places = np.searchsorted(traces[name].time, at)
            value, spread = (traces[each].values[places] for each in (name, f"{name}_standard_deviation"))
            true = np.interp(traces[name].time[places], whole[truth].time, whole[truth].values)
            moving = np.interp(at, whole["truth_speed"].time, whole["truth_speed"].values) > 1.5
            compared = _compared(value - factor * true, spread, moving)
        yield {"car": car.name, "monitor": monitor, "file": file, **_said(finding), **compared}


def _said(finding: Finding) -> Row:
    return {"said": str(finding.status), "headline": finding.headline, "false": float(finding.status in FALSE)}


def _compared(error: np.ndarray, spread: np.ndarray, counted: np.ndarray) -> Row:
    """Columns `samples`, `held` in the 95 % band, `share` of these, and `error`, root mean square; none without one."""
    known = np.isfinite(error) & np.isfinite(spread) & counted
    if not known.any():
        return {}
    held = np.abs(error[known]) <= 1.96 * spread[known]
    rms = float(np.sqrt(np.mean(error[known] ** 2)))
    return {"samples": float(known.sum()), "held": float(held.sum()), "share": float(held.mean()), "error": rms}


class Over(NamedTuple):
    """A diagnosis, and its estimates over time."""

    diagnosis: Diagnosis
    traces: Recording


def over(monitor: str, vehicle: Vehicle, recording: Recording) -> Over:
    """Run a monitor over a recording, with the spread of the parameters, and keep its traces."""
    definition, variant = find(monitor)
    kept = OverTime()
    process = Run(definition, variant, vehicle, kept=kept.add, uncertain=True)
    process.add(recording)
    diagnosis = process.finish()
    # Estimates that a report withholds count in the coverage as well.
    units = {**process.session.traces, **{name: trace.unit for name, trace in diagnosis.traces.items()}}
    return Over(diagnosis, kept.recording(units, monitor))


REFERENCE = "sideslip_angle"  # Channel of the measured sideslip angle, which scores an estimate and never feeds it
CLASSES = ("small", "midsize", "large", "suv", "van", "race-car")  # Classes whose typical values judge every car


@dataclass(frozen=True)
class Known:
    """Brochure data of a real car, and its recording."""

    vehicle: str  # name of its shipped vehicle file; it gives the channel map and judges the other cars
    kind: str  # class of the car
    mass: float  # mass [kg]
    wheelbase: float  # wheelbase [m]
    file: tuple[str, str]  # folder and file name of the recording
    dbc: str | None = None  # bus database of the recording
    torques_known: bool = True  # whether its torques are in N*m
    # position of its sideslip sensor ahead of the rear axle [m]; None: the centre of gravity
    reference: float | None = None


KNOWN = (
    Known("rav4", "suv", 1690.0, 2.66, ("rav4_highway_minute", "can.log"), "rav4", False),
    Known("revsted-car", "midsize", 1700.0, 2.7, ("revsted_slip_angle", "obd.csv"), reference=0.834),
    Known("ferrari-250lm", "race-car", 982.0, 2.40, ("ferrari_250lm_race", "laps.parquet")),
)
"""The real cars of the study."""


def over_real_cars(known: Known) -> list[Row]:
    """Recordings of three real cars, judged with files that are not theirs.

    The files are begun with mass and wheelbase of a brochure and typical values of six classes, or those of the two
    other cars. Nothing measured on the car is used but its channel map; a reference only scores.
    """
    whole = recorded(*known.file, dbc=known.dbc, channel_map=load(known.vehicle).channel_map)
    if whole is None:
        return []
    bare = without_reference(whole)
    files = {
        f"class {kind}": brochure_car(known.vehicle, kind, known.mass, known.wheelbase, known.torques_known)
        for kind in CLASSES
    }
    unit = "N*m" if known.torques_known else "count"
    others = [each.vehicle for each in KNOWN if each != known]
    files |= {f"file of {name}": dataclasses.replace(load(name), torque_unit=unit) for name in others}
    rows: list[Row] = []
    for file, vehicle in files.items():
        for name, monitor in MONITORS.items():
            if monitor.default is None or monitor.condition:
                continue
            try:
                finding = diagnose(bare, vehicle, name).findings[0]
            except (InputError, ParameterError):
                continue
            rows.append({"car": known.vehicle, "file": file, "monitor": name, **_said(finding)})
    if REFERENCE in whole:
        share, error = beside_reference(whole, files[f"class {known.kind}"], known.reference)
        _, own = beside_reference(whole, load(known.vehicle), known.reference)
        rows.append({"car": known.vehicle, "file": "brochure", "monitor": "", "share": share, "over_own": error / own})
    return rows


def without_reference(recording: Recording) -> Recording:
    """The recording without the sideslip reference."""
    return Recording({name: each for name, each in recording.channels.items() if name != REFERENCE})


def beside_reference(recording: Recording, vehicle: Vehicle, place: float | None = None) -> tuple[float, float]:
    """Share of the reference in the 95 % band of the sideslip, and root mean square error [rad].

    Args:
        place: position of the sideslip sensor ahead of the rear axle [m], to which the estimate is transformed; None:
            the centre of gravity
    """
    traces = over("sideslip", vehicle, without_reference(recording)).traces
    value, deviation = traces[REFERENCE], traces[f"{REFERENCE}_standard_deviation"]
    reference, at = recording[REFERENCE], value.time
    ahead = 0.0 if place is None else place - vehicle["rear_distance"]
    yaw_rate, speed = (
        np.interp(at, recording[name].time, recording[name].values) for name in ("yaw_rate", "vehicle_speed")
    )
    known = np.isfinite(reference.values)
    # The sideslip at a point ahead of the centre of gravity is larger by its distance times yaw rate over speed.
    there = value.values + ahead * yaw_rate / np.maximum(speed, 1.0)
    error = there - np.interp(at, reference.time[known], reference.values[known])
    found = _compared(error, deviation.values, np.ones(len(at), dtype=bool))
    return float(found["share"]), float(found["error"])
