"""The paper's test and its Figures 6 to 10: acceleration from standstill to 6.7 m/s, then a steering manoeuvre."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_least
from tierod.core.content import Chart, Heading, Item, Lines, Mark, Panel
from tierod.physics.single_track import front_slip_speed
from tierod.physics.tyre import linear_lateral_force
from tierod_lab.ground import courses as proving_courses
from tierod_lab.papers.sideslip.estimators import MODEL, Course, courses, error
from tierod_lab.papers.sideslip.matching import matched
from tierod_lab.papers.sideslip.observer import LowSpeed
from tierod_lab.papers.sideslip.reported import PAPER_TEST, SEEDS
from tierod_lab.papers.sideslip.setting import SLOW, Driven, driven, virtual_car
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.table import PAPER
from tierod_lab.studies.effort import Effort

COURSE = "sideslip-test"
CAR = "virtual car"
DRAWN = 25
"""Decimation of the drawn curves."""

STEERED = 9.0
"""Time at which steering begins [s]."""

DEGREES = float(np.degrees(1.0))

CONVENTIONAL, TWO_STAGE = "conventional, poles x10", "two-stage, Kalman"
"""Observers that redraw the figures: conventional with the printed poles, two-stage with Kalman gains."""


def items(effort: Effort) -> Iterator[Item]:
    p = matched(CAR, SLOW.speed, SLOW.steer)
    drive = driven(virtual_car(), proving_courses.load(COURSE), SEEDS.of(PAPER_TEST, 1)[0])
    found = courses(p, drive)
    alone = found[MODEL].sideslip_angle
    yield Heading(
        "The test of the paper",
        (
            "The virtual car starts from a stand, reaches 6.7 m/s after seven seconds and steers from the ninth on: "
            "8 degrees at 0.25 Hz, then 6 degrees at 0.5 Hz. What the paper's car steered is not printed. The "
            "paper's reference came from GPS and inertial sensors; here it is the truth.",
        ),
    )
    yield _steering("figure-6", "Figure 6", "conventional", found[CONVENTIONAL], drive)
    yield _motion("figure-7", "Figure 7", "conventional", found[CONVENTIONAL], drive, alone)
    yield _steering("figure-8", "Figure 8", "disturbance", found[TWO_STAGE], drive)
    yield _motion("figure-9", "Figure 9", "two-stage", found[TWO_STAGE], drive, alone)
    modelled = _modelled(p, drive)
    yield _torque(found[TWO_STAGE], drive, modelled)
    yield from _claims(found, drive, modelled)


def _line(drive: Driven, name: str, values: np.ndarray, factor: float = 1.0, dashed: bool = False) -> Lines:
    return Lines(name, drive.time[::DRAWN], factor * values[::DRAWN], dashed)


def _panel(title: str, unit: str, marks: tuple[Mark, ...]) -> Panel:
    return Panel(title, "time [s]", unit, marks)


def _steering(name: str, title: str, observer: str, course: Course, drive: Driven) -> Chart:
    angles = _both(course, drive, drive.signals["road_wheel_angle"], "estimated_road_wheel_angle", "measured")
    rates = _both(course, drive, drive.truths["road_wheel_rate"], "estimated_road_wheel_rate", "truth")
    return Chart(
        name,
        f"{title}: steering angle and rate, {observer} observer",
        "Angle of the road wheels as measured and as estimated; its rate as it is and as estimated.",
        "Time courses of angle and rate of the road wheels.",
        (_panel("steering angle", "angle [deg]", angles), _panel("steering rate", "rate [deg/s]", rates)),
    )


def _both(course: Course, drive: Driven, known: np.ndarray, output: str, called: str) -> tuple[Mark, ...]:
    assert course.result is not None
    return (
        _line(drive, called, known, DEGREES),
        _line(drive, "estimated", course.result[output], DEGREES, dashed=True),
    )


def _motion(name: str, title: str, observer: str, course: Course, drive: Driven, model: np.ndarray) -> Chart:
    sideslip = (
        *_both(course, drive, drive.truths["sideslip_angle"], "sideslip_angle", "truth"),
        _line(drive, "linear model", model, DEGREES, dashed=True),
    )
    yaw_rate = _both(course, drive, drive.signals["yaw_rate"], "estimated_yaw_rate", "measured")
    return Chart(
        name,
        f"{title}: sideslip angle and yaw rate, {observer} observer",
        "Sideslip angle as it is, as estimated, and of the linear model without feedback; yaw rate.",
        "Time courses of sideslip angle and yaw rate.",
        (_panel("sideslip angle", "angle [deg]", sideslip), _panel("yaw rate", "rate [deg/s]", yaw_rate)),
    )


def _modelled(p: SteeredVehicle.Parameters, drive: Driven) -> np.ndarray:
    """Aligning torque [N m] by eqs (3) and (12) from the true motion, (n,)."""
    speed = np.maximum(drive.truths["speed"], LowSpeed.slowest)
    sideslip, yaw_rate, steer = (
        drive.truths["sideslip_angle"],
        drive.truths["yaw_rate"],
        drive.signals["road_wheel_angle"],
    )
    front = front_slip_speed(speed * sideslip, yaw_rate, speed, steer, p.front_distance) / speed
    force: np.ndarray = linear_lateral_force(front, p.front_cornering_stiffness)
    return (p.mechanical_trail + p.pneumatic_trail) * force


def _torque(course: Course, drive: Driven, modelled: np.ndarray) -> Chart:
    assert course.result is not None
    marks = (
        _line(drive, "truth", drive.truths["kingpin_torque"]),
        _line(drive, "estimated", course.result["self_aligning_torque"], dashed=True),
        _line(drive, "eq (3) from the true motion", modelled, dashed=True),
    )
    return Chart(
        "figure-10",
        "Figure 10: estimated disturbance torque",
        "Torque of the road about the kingpins: as it is, as the disturbance observer finds it, and as the linear tyre "
        "would have it. What lifts the car and the scrub of tyres that hardly roll are in the first two.",
        "Time courses of three torques.",
        (_panel("torque about the kingpins", "torque [N·m]", marks),),
    )


def _claims(found: dict[str, Course], drive: Driven, modelled: np.ndarray) -> Iterator[Claim]:
    manoeuvre = drive.time > STEERED
    truth = drive.truths["kingpin_torque"]
    course = found[TWO_STAGE]
    assert course.result is not None
    estimated = course.result["self_aligning_torque"]
    for name, words in ((CONVENTIONAL, "conventional"), (TWO_STAGE, "two-stage")):
        yield Claim(
            f"paper.test-{words}",
            f"In the test the sideslip of the {words} observer correlates well with the reference.",
            f"{PAPER}, section VII, Figures 7 and 9",
            "well",
            float(np.corrcoef(found[name].sideslip_angle, drive.truths["sideslip_angle"])[0, 1]),
            at_least(0.98),
            "",
            f"Over the whole test. Root mean square error {error(found[name], drive):.3f} degrees ({name}).",
        )
    yield Claim(
        "paper.disturbance-torque",
        "The aligning torque of eq (3) does not predict the disturbance torque well.",
        f"{PAPER}, section VII, Figure 10",
        "not as well predicted",
        _relative(modelled - truth, truth, manoeuvre),
        at_least(0.2),
        "",
        "Root mean square error over the spread of the torque, with the true motion; that of the disturbance observer "
        f"is {_relative(estimated - truth, truth, manoeuvre):.2f}.",
    )


def _relative(difference: np.ndarray, truth: np.ndarray, within: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference[within] ** 2)) / np.std(truth[within]))
