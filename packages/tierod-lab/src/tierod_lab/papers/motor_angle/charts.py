"""Charts of the study of the motor's angle: the paper's Figures 4 to 7, a held motor, loads, delays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.content import Band, Chart, Lines, Mark, Panel, Points
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.papers.motor_angle.bench import RATE, parameters
from tierod_lab.papers.motor_angle.observer_datasets import CAR, FAST, HELD, CarDrive, car_drive, methods
from tierod_lab.papers.motor_angle.reported import SEEDS
from tierod_lab.papers.motor_angle.robustness_datasets import MOVING, STILL, held_drive
from tierod_lab.papers.motor_angle.sensor_faults import STUCK, drift, offset
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

EVERY = 4  # Decimation of the drawn curves [true values]


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """All charts, from the datasets and from drives that are simulated once more."""
    slalom = car_drive("slalom", 12.0 if effort.quick else 30.0, SEEDS.of("in the car", 2)[0])
    parking = car_drive("parking", 30.0 if effort.quick else 40.0, SEEDS.of("in the car", 2)[1])
    observers = methods(CAR)
    wrong, lost = ({name: seen.error(each) for name, each in observers.items()} for seen in (slalom, parking))
    yield _whole("motor-angle-figure-4", "Slalom (Figure 4)", slalom, wrong)
    yield _whole("motor-angle-figure-5", "Parking (Figure 5)", parking, lost)
    yield _section("motor-angle-figure-6", "From lock to lock (Figure 6)", parking, lost, FAST)
    yield _section("motor-angle-figure-7", "Held near the lock (Figure 7)", parking, lost, HELD)
    yield _held()
    yield _delays(frames["faults"])
    yield _sizes(frames["faults"])


def _printed(names: Mapping[str, np.ndarray]) -> list[str]:
    return [name for name in names if name.endswith(("as printed", "held when slow"))]


def _whole(name: str, title: str, seen: CarDrive, errors: dict[str, np.ndarray]) -> Chart:
    kept, printed = slice(None, None, EVERY), _printed(errors)
    measured = Lines("measured", seen.time[kept], seen.samples[seen.places, 4][kept])
    angles = [Lines(each, seen.time[kept], (seen.angle + errors[each])[kept], dashed=True) for each in printed]
    others = [Lines(each, seen.time[kept], errors[each][kept]) for each in errors if each not in printed]
    return Chart(
        name,
        title,
        "Above: angle of the motor as measured and by the four methods of the paper. Below: errors with the load as a "
        "state, and of the methods that the paper does not have.",
        "Without load the observers leave the measured angle; with load they stay near it, the default nearest.",
        (
            Panel("", "time (s)", "angle (rad)", (measured, *angles)),
            Panel("", "time (s)", "error of the angle (rad)", tuple(others)),
        ),
    )


def _section(name: str, title: str, seen: CarDrive, errors: dict[str, np.ndarray], span: tuple[float, float]) -> Chart:
    part = (seen.time >= span[0]) & (seen.time <= span[1])
    time, first = seen.time[part], int(np.argmax(part))
    changes = [Lines(each, time, errors[each][part] - errors[each][first]) for each in errors]
    return Chart(
        name,
        title,
        "Every method begins the section at the true angle, so that what it loses there is seen.",
        "What each method loses while the motor turns fast, or stands.",
        (Panel("", "time (s)", "lost angle (rad)", tuple(changes)),),
    )


def _held() -> Chart:
    seen = held_drive(SEEDS.of("standing", 1)[0])
    part = slice(round((MOVING - 0.6) * RATE), round((MOVING + STILL + 1.0) * RATE), 20)
    found = seen.observed(MotorAngleObserver(parameters()[1]))
    time, deviation = seen.time[part], 2.0 * found["motor_angle_standard_deviation"][part]
    marks: list[Mark] = [Band("default", time, -deviation, deviation)]
    for name in ("Luenberger, with load", "Kalman filter, with load", "default"):
        away = seen.error(methods()[name])
        marks.append(Lines(name, time, away[part] - away[part][0]))
    return Chart(
        "motor-angle-held",
        "An observer's angle while the motor is held (Figure 7)",
        f"Held from {MOVING:g} to {MOVING + STILL:g} s. Errors from the begin of the section on; the band is twice the "
        "standard deviation that the default claims. The others integrate a speed and turn by the measured angle.",
        "Errors of three observers while the motor stands: the default stays, and its band grows.",
        (Panel("", "time (s)", "error of the angle (rad)", tuple(marks)),),
    )


def _delays(faults: Frame) -> Chart:
    lines = []
    for fault in (offset(5.0), offset(10.0), drift(20.0), STUCK):
        values = np.sort(faults.where({"speed": 0.0, "fault": fault.name})["turning"])
        kept = values[np.isfinite(values)]
        shares = np.arange(1, len(kept) + 1) / max(len(values), 1)
        lines.append(Lines(fault.name, np.repeat(kept, 2), np.repeat(np.r_[0.0, shares], 2)[1:-1]))
    return Chart(
        "motor-angle-delays",
        "Share of faults that are found, over the delay",
        "Delays count the time in which the motor turns; a drift counts from when it has reached five degrees.",
        "Curves of the share of faults found over the delay, for offsets, a drift and a stuck sensor.",
        (Panel("", "delay (ms of turning)", "share found", tuple(lines), levels=(("95 %", 0.95),)),),
    )


def _sizes(faults: Frame) -> Chart:
    sizes = (2.0, 3.5, 5.0, 10.0, 20.0, 60.0, 180.0)
    marks = []
    for (speed,), rows in faults.where({"speed": ">= 1"}).groups("speed"):
        shares = [float(np.mean(rows.where({"fault": offset(size).name})["found"])) for size in sizes]
        marks.append(Points(f"{speed:g} rad/s", sizes, shares))
    return Chart(
        "motor-angle-offset-sizes",
        "Offsets by size and speed",
        "Share found within 1.5 s. Two degrees are below what the sum forgives.",
        "The larger an offset, the more surely it is found; below three degrees it is not found, as intended.",
        (Panel("", "offset (° electrical)", "share found", tuple(marks), logarithmic_along=True),),
    )
