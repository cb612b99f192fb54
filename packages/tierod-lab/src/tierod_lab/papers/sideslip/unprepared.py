"""Two real cars with parameters from tape measure and scale: typical tyres, default noises, no fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip import car_park, race_laps
from tierod_lab.papers.sideslip.calibration import BesideTruth, beside_truth
from tierod_lab.papers.sideslip.real_recordings import GOAL, recorded
from tierod_lab.papers.sideslip.typical_cars import PASSENGER, SIMPLE, SPORTS, Class, measured_wrong
from tierod_lab.studies.effort import Effort

MOST_WORSE = 1.3
"""Largest accepted ratio of the error to that with the shipped vehicle file [-]."""


@dataclass(frozen=True)
class Unprepared:
    """A real car that is judged without any fit.

    Args:
        name: name within those of the claims
        file, vehicle: recording, and the vehicle file that gives mass and distances
        kind: class of its tyres
        rate: sampling rate [Hz]
        start: time after the start of the recording from which the estimate is judged [s]
    """

    name: str
    file: tuple[str, str]
    vehicle: str
    kind: Class
    rate: float
    start: float


CARS = (
    Unprepared("race-laps", race_laps.FILE, race_laps.VEHICLE, SPORTS, 100.0, 110.0),
    Unprepared("passenger-car", car_park.FILE, car_park.VEHICLE, PASSENGER, car_park.RATE, 1.0),
)
"""The real cars. The first 110 s of the laps, two of five blocks, are not judged: the default noises were chosen in
view of them."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Cars without preparation",
        (
            "Mass and distances as tape and scale give them, with errors of 3 cm and 3 %; tyres typical of the class, "
            "default noises, no reference. Beside it the vehicle file that was fitted to the car, and three simple "
            "estimates with the same typical tyres. The zeros of the sensors are those of the channel map.",
        ),
    )
    for each in CARS:
        yield from _judged(each, recorded(each.file, each.vehicle))


def _judged(unprepared: Unprepared, recording: Recording | None) -> Iterator[Item]:
    if recording is None:
        for key in ("worse", "band", "simple"):
            yield Claim(
                f"unprepared.{unprepared.name}-{key}", "A car without a fit.", GOAL, None, None, None, "", NO_DATA
            )
        return
    car, rate = load(unprepared.vehicle), unprepared.rate
    start = recording.span[0] + unprepared.start
    cars = measured_wrong(car, unprepared.kind)
    shipped = beside_truth(recording, car, rate)
    drawn = [beside_truth(recording, each, rate) for each in cars]
    simple = {name: estimate(recording, cars[0], rate) for name, estimate in SIMPLE.items()}
    yield _table(unprepared, start, shipped, drawn, simple)
    errors = [each.figures(start) for each in drawn]
    best = min(each.figures(start).rms for each in simple.values())
    fitted, worst = shipped.figures(start), max(errors, key=lambda each: each.rms)
    ratio = errors[0].rms / fitted.rms
    note = f"{worst.rms / fitted.rms:.2f} in the worst corner of tape and scale."
    yield Claim(
        f"unprepared.{unprepared.name}-worse",
        "Error of the sideslip with typical tyres and default noises over that with the fitted vehicle file.",
        GOAL,
        None,
        ratio,
        at_most(MOST_WORSE),
        "",
        note,
        cause="Typical tyres of its class are not those of this car; the best of three simple estimates has "
        f"{best / fitted.rms:.2f} times the error of the fitted file. Laps with a reference mend it, see the blocks.",
    )
    yield Claim(
        f"unprepared.{unprepared.name}-band",
        "Share of the truth in the 95 % band, typical tyres and default noises, parameters taken as exact.",
        GOAL,
        None,
        errors[0].coverage,
        at_least(0.9),
        "",
        f"{min(each.coverage for each in errors):.2f} in the worst corner.",
        cause="Parameters are taken as exact here, so that the band lacks their spread. With it, as by default, the "
        "band is wider, see the study of cars without preparation.",
    )
    yield Claim(
        f"unprepared.{unprepared.name}-simple",
        "Error of the sideslip over that of the best of three simple estimates.",
        GOAL,
        None,
        errors[0].rms / best,
        at_most(1.0),
        "",
        f"The best has {math.degrees(best):.3f} degrees (root mean square).",
    )


def _table(
    unprepared: Unprepared, start: float, shipped: BesideTruth, drawn: list[BesideTruth], simple: dict[str, BesideTruth]
) -> Table:
    worst = max(drawn, key=lambda each: each.figures(start).rms)
    rows = [(name, str(each.figures(start)), "") for name, each in simple.items()]
    compared = {
        "combined, typical tyres, default noises": drawn[0],
        "the same, worst corner of tape and scale": worst,
        "combined, fitted vehicle file": shipped,
    }
    for name, each in compared.items():
        figures = each.figures(start)
        rows.append((name, str(figures), f"{100.0 * figures.coverage:.0f} %"))
    return Table(
        f"{unprepared.vehicle}: mean absolute / root mean square error of the sideslip (degrees)",
        ("estimate", f"from {unprepared.start:.0f} s on", "in the 95 % band"),
        tuple(rows),
    )
