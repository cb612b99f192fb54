"""Charts of the study of sideslip: the paper's Figures 6 to 10, a peak announced, a lap of a race."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.content import Band, Chart, Lines, Mark, Panel
from tierod.vehicles import load
from tierod_lab.papers.sideslip.calibration import BesideTruth, beside_truth
from tierod_lab.papers.sideslip.combined_datasets import SHOWN, TURNING, Ramp, ramp
from tierod_lab.papers.sideslip.estimators import MODEL, Course, courses
from tierod_lab.papers.sideslip.matching import matched
from tierod_lab.papers.sideslip.observer_datasets import CONVENTIONAL, TWO_STAGE, modelled_torque, paper_test
from tierod_lab.papers.sideslip.real_datasets import RACE
from tierod_lab.papers.sideslip.reported import SEEDS
from tierod_lab.papers.sideslip.setting import SLOW, Driven
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

DRAWN = 25  # Decimation of the drawn curves
DEGREES = float(np.degrees(1.0))
LAP = (253.3, 349.9)  # Start and end of the second lap [s]; the curvature of the path repeats after 3.1 km


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """All charts, from drives that are simulated once more."""
    p, drive = matched("virtual car", SLOW.speed, SLOW.steer), paper_test(SEEDS.of("the test of the paper", 1)[0])
    found = courses(p, drive)
    alone = found[MODEL].sideslip_angle
    yield _steering("figure-6", "Figure 6", "conventional", found[CONVENTIONAL], drive)
    yield _motion("figure-7", "Figure 7", "conventional", found[CONVENTIONAL], drive, alone)
    yield _steering("figure-8", "Figure 8", "disturbance", found[TWO_STAGE], drive)
    yield _motion("figure-9", "Figure 9", "two-stage", found[TWO_STAGE], drive, alone)
    yield _torque(found[TWO_STAGE], drive, modelled_torque(p, drive))
    yield _low_friction(ramp(SHOWN, SEEDS.of("ramps to the limit of grip", 1)[0]))
    if (laps := RACE.recording()) is not None:
        yield _picture(beside_truth(laps, load(RACE.vehicle)))


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


def _low_friction(shown: Ramp) -> Chart:
    time, result = shown.drive.time, shown.result
    kept = (time > TURNING - 2.0) & (time < shown.peak + 2.0)
    used, deviation = result["front_friction_used"], result["front_friction_used_deviation"]
    marks = (("announced", shown.announced), ("peak", shown.peak))
    return Chart(
        "low-friction",
        "The peak announced",
        "Road friction 0.35. Upper field: share of the greatest front force in use, true and estimated with one "
        "standard deviation. Lower field: the sideslip angle.",
        f"The announcement comes {shown.peak - shown.announced:.1f} s before the peak.",
        (
            Panel(
                "Front axle",
                "time (s)",
                "share of the greatest force",
                (
                    Lines("true", time[kept], shown.share[kept]),
                    Lines("estimated", time[kept], used[kept]),
                    Band("estimated", time[kept], (used - deviation)[kept], (used + deviation)[kept]),
                ),
                uprights=marks,
            ),
            Panel(
                "Sideslip",
                "time (s)",
                "sideslip angle (deg)",
                (
                    Lines("true", time[kept], np.degrees(shown.drive.truth("sideslip_angle"))[kept]),
                    Lines("estimated", time[kept], np.degrees(result["sideslip_angle"])[kept]),
                ),
                uprights=marks,
            ),
        ),
    )


def _picture(seen: BesideTruth) -> Chart:
    shown = np.flatnonzero((seen.time >= LAP[0]) & (seen.time < LAP[1]))[::10]
    time, estimate, band = seen.time[shown], np.degrees(seen.estimate[shown]), 1.96 * np.degrees(seen.deviation[shown])
    marks = (
        Band("95 % band", time, estimate - band, estimate + band),
        Lines("combined estimator", time, estimate),
        Lines("INS", time, np.degrees(seen.truth[shown]), dashed=True),
    )
    return Chart(
        "sideslip-of-a-lap",
        "Sideslip over a lap",
        "Second lap of the Ferrari: the estimate with its band, and the truth.",
        "The estimate follows the truth between minus five and three degrees within a few tenths of a degree.",
        (Panel("Sideslip angle", "time (s)", "sideslip (degrees)", marks),),
    )
