"""Real fault-free cars judged with typical values of several classes and with the vehicle files of other cars."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Finding
from tierod.core.recording import Recording
from tierod.monitors.diagnose import diagnose
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load
from tierod.vehicles.vehicle import Vehicle
from tierod_lab.papers.condition.real_cars import CARS
from tierod_lab.papers.own_car.brochure import brochure_car
from tierod_lab.papers.own_car.judging import FALSE, over
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip.real_datasets import RACE

GOAL = "goal of tierod"

REFERENCE = "sideslip_angle"  # Channel of the measured sideslip angle, which scores an estimate and never feeds it
CLASSES = ("small", "midsize", "large", "suv", "van", "race-car")  # Classes whose typical values judge every car


@dataclass(frozen=True)
class Known:
    """Brochure data of a real car."""

    vehicle: str  # name of its shipped vehicle file; it gives the channel map and judges the other cars
    kind: str  # class of the car
    mass: float  # mass [kg]
    wheelbase: float  # wheelbase [m]
    torques_known: bool = True  # whether its torques are in N*m
    # position of its sideslip sensor ahead of the rear axle [m]; None: the centre of gravity
    reference: float | None = None


KNOWN = (
    Known("rav4", "suv", 1690.0, 2.66, False),
    Known("revsted-car", "midsize", 1700.0, 2.7, reference=0.834),
    Known(RACE.vehicle, "race-car", 982.0, 2.40),
)
"""The real cars of the study."""


class Seen(NamedTuple):
    """Finding of a monitor on a real recording with a vehicle file that is not the car's own."""

    car: str
    file: str
    monitor: str
    finding: Finding


def recording_of(known: Known) -> Recording | None:
    """The recording of a real car; None where it is not available."""
    for car in CARS:
        if car.vehicle == known.vehicle:
            return car.recording()
    return RACE.recording()


def files_for(known: Known) -> Iterator[tuple[str, Vehicle]]:
    """Vehicles without any value measured on the car, by name: of all classes, and of the other cars."""
    for kind in CLASSES:
        yield f"class {kind}", brochure_car(known.vehicle, kind, known.mass, known.wheelbase, known.torques_known)
    for other in KNOWN:
        if other.vehicle != known.vehicle:
            car = load(other.vehicle)
            yield f"file of {other.vehicle}", replace(car, torque_unit="N*m" if known.torques_known else "count")


def verdicts(known: Known, recording: Recording) -> Iterator[Seen]:
    """Judge a recording by every monitor that can run, with every file.

    Args:
        recording: the recording; a sideslip reference in it is not used
    """
    bare = without_reference(recording)
    for file, vehicle in files_for(known):
        for name, monitor in MONITORS.items():
            if monitor.default is None or monitor.condition:
                continue
            try:
                finding = diagnose(bare, vehicle, name).findings[0]
            except (InputError, ParameterError):
                continue
            yield Seen(known.vehicle, file, name, finding)


def without_reference(recording: Recording) -> Recording:
    """The recording without the sideslip reference."""
    return Recording({name: each for name, each in recording.channels.items() if name != REFERENCE})


def items() -> Iterator[Item]:
    text = (
        "Recordings of three real cars, judged with mass and wheelbase of a brochure, typical values of six "
        "classes, and with the files of the two other cars. Nothing measured on the car is used but its channel map; a "
        "reference only scores.",
    )
    yield Heading("Real cars with files that are not theirs", text)
    here = {known: recording for known in KNOWN if (recording := recording_of(known)) is not None}
    seen = [each for known, recording in here.items() for each in verdicts(known, recording)]
    false = [each for each in seen if each.finding.status in FALSE]
    if seen:
        yield _statuses(seen)
        rows = tuple((each.car, each.file, each.monitor, each.finding.headline) for each in false)
        yield Table(
            "False verdicts on real cars", ("car", "vehicle file", "monitor", "verdict"), rows or (("none",) * 4,)
        )
    note = f"Of {len(seen)} verdicts." if seen else NO_DATA
    counted = float(len(false)) if seen else None
    yield Claim(
        "real.false", "Verdicts of a fault on real fault-free drives.", GOAL, None, counted, exactly(0.0), "", note
    )
    for known in KNOWN[1:]:
        yield from _sideslip(known, here.get(known))


def _statuses(seen: list[Seen]) -> Table:
    monitors = sorted({each.monitor for each in seen})
    pairs = list(dict.fromkeys((each.car, each.file) for each in seen))
    of = {(each.car, each.file, each.monitor): str(each.finding.status) for each in seen}
    rows = tuple((*pair, *(of.get((*pair, monitor), "cannot run") for monitor in monitors)) for pair in pairs)
    return Table("Verdicts on real fault-free drives", ("car", "vehicle file", *monitors), rows)


UNLIKE = (
    "The shipped file has tyres and noises fitted to the reference of this very drive; tyres typical of a class are "
    "not those of one car. Laps with a reference, or more drives to identify from, mend it."
)


def _sideslip(known: Known, recording: Recording | None) -> Iterator[Claim]:
    band, worse = math.nan, math.nan
    if recording is not None:
        brochure = brochure_car(known.vehicle, known.kind, known.mass, known.wheelbase)
        held, error = beside_reference(recording, brochure, known.reference)
        _, best = beside_reference(recording, load(known.vehicle), known.reference)
        band, worse = held, error / best
    figures: tuple[tuple[str, str, float, Goal], ...] = (
        ("band", "Share of the reference in the 95 % band of the sideslip", band, at_least(0.9)),
        ("error", "Error of the sideslip over that with the shipped file", worse, at_most(1.3)),
    )
    place = "" if known.reference is None else " Compared where the optical sensor looks."
    note = f"The distances are typical of the class too.{place}" if recording is not None else NO_DATA
    for key, what, measured, goal in figures:
        claim = f"{what}, {known.vehicle} by mass and wheelbase of a brochure."
        value = None if recording is None else measured
        cause = UNLIKE if key == "error" else ""
        yield Claim(f"real.{known.vehicle}-{key}", claim, GOAL, None, value, goal, "", note, cause=cause)


def beside_reference(recording: Recording, vehicle: Vehicle, place: float | None = None) -> tuple[float, float]:
    """Share of the reference in the 95 % band of the sideslip, and root mean square error [rad].

    Args:
        place: position of the sideslip sensor ahead of the rear axle [m], to which the estimate is transformed; None:
            the centre of gravity
    """
    traces = over("sideslip", vehicle, without_reference(recording), uncertain=True).traces
    value, deviation = traces[REFERENCE], traces[f"{REFERENCE}_standard_deviation"]
    reference, time = recording[REFERENCE], value.time
    ahead = 0.0 if place is None else place - vehicle["rear_distance"]
    yaw_rate, speed = (
        np.interp(time, recording[name].time, recording[name].values) for name in ("yaw_rate", "vehicle_speed")
    )
    at = np.isfinite(reference.values)
    # The sideslip at a point ahead of the centre of gravity is larger by its distance times yaw rate over speed.
    there = value.values + ahead * yaw_rate / np.maximum(speed, 1.0)
    error = there - np.interp(time, reference.time[at], reference.values[at])
    known = np.isfinite(error) & np.isfinite(deviation.values)
    held = np.abs(error[known]) <= 1.96 * deviation.values[known]
    return float(held.mean()), float(np.sqrt(np.mean(error[known] ** 2)))
