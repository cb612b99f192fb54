"""The paper's observers of the sideslip on two virtual cars: right and wrong parameters, poles, neutral steer."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Model
from tierod.methods.analysis.observability import observability
from tierod.models.linear import LinearSystem, discretise, linearise
from tierod.models.single_track import SingleTrack
from tierod.physics.single_track import front_slip_speed
from tierod.physics.tyre import linear_lateral_force
from tierod_lab.ground import courses as proving_courses
from tierod_lab.papers.sideslip.conventional import ConventionalKalman, conventional_kalman, conventional_poles
from tierod_lab.papers.sideslip.estimators import MODEL, OBSERVERS, Course, courses, error, observed, open_loop
from tierod_lab.papers.sideslip.matching import from_file, matched, matched_to
from tierod_lab.papers.sideslip.observer import LowSpeed, finer_steps
from tierod_lab.papers.sideslip.setting import (
    BANKED,
    FAST,
    RATE,
    SLIPPERY,
    SLOW,
    WINDY,
    Drive,
    Driven,
    driven,
    on,
    virtual_car,
)
from tierod_lab.papers.sideslip.steered_vehicle import (
    SteeredVehicle,
    TorqueShownVehicle,
    TurnedSingleTrack,
    TurnedSteeredVehicle,
)
from tierod_lab.papers.sideslip.two_stage import two_stage_poles
from tierod_lab.studies.metrics import Row

CONVENTIONAL, TWO_STAGE = "conventional, poles x10", "two-stage, Kalman"
"""Observers that redraw the figures: conventional with the printed poles, two-stage with Kalman gains."""
STEERED = 9.0  # Time at which steering begins in the paper's test [s]
CASES: dict[str, tuple[Drive, dict[str, float]]] = {
    "6.7 m/s": (SLOW, {}),
    "25 m/s": (FAST, {}),
    "25 m/s, 2°": (dataclasses.replace(FAST, steer=2.0), {}),
    "neutral steer": (dataclasses.replace(FAST, neutral=True), {}),
    "both stiffnesses +20 %": (FAST, {"front_cornering_stiffness": 1.2, "rear_cornering_stiffness": 1.2}),
    "friction not compensated": (FAST, {"road_wheel_friction": 0.0}),
    "pneumatic trail +50 %": (FAST, {"pneumatic_trail": 1.5}),
    "low friction, 0.35": (dataclasses.replace(FAST, conditions=SLIPPERY), {}),
    "bank 3°": (dataclasses.replace(FAST, conditions=BANKED), {}),
    "crosswind 500 N": (dataclasses.replace(FAST, conditions=WINDY), {}),
}
"""Drive, and factors of the parameters that the observers assume, by name; 8° at 0.25 Hz or 1.3° at 0.3 Hz."""


def paper_test(seed: int) -> Driven:
    """The test of the paper: from a stand to 6.7 m/s, then 8 degrees at 0.25 Hz and 6 degrees at 0.5 Hz."""
    return driven(virtual_car(), proving_courses.load("sideslip-test"), seed)


def modelled_torque(p: SteeredVehicle.Parameters, drive: Driven) -> np.ndarray:
    """Aligning torque [N m] by eqs (3) and (12) from the true motion, (n,)."""
    speed = np.maximum(drive.truths["speed"], LowSpeed.slowest)
    sideslip, yaw_rate = drive.truths["sideslip_angle"], drive.truths["yaw_rate"]
    steer = drive.signals["road_wheel_angle"]
    front = front_slip_speed(speed * sideslip, yaw_rate, speed, steer, p.front_distance) / speed
    force: np.ndarray = linear_lateral_force(front, p.front_cornering_stiffness)
    return (p.mechanical_trail + p.pneumatic_trail) * force


def driven_test(seed: int) -> list[Row]:
    """The virtual car reaches 6.7 m/s after seven seconds and steers from the ninth on.

    What the paper's car steered is not printed. The paper's reference came from GPS and inertial sensors; here it is
    the truth. Misses are root mean square errors of the aligning torque over its spread.
    """
    p, drive = matched("virtual car", SLOW.speed, SLOW.steer), paper_test(seed)
    found = courses(p, drive)
    rows: list[Row] = [
        {
            "observer": name,
            "correlation": float(np.corrcoef(found[name].sideslip_angle, drive.truths["sideslip_angle"])[0, 1]),
            "error": error(found[name], drive),
        }
        for name in (CONVENTIONAL, TWO_STAGE)
    ]
    within, truth = drive.time > STEERED, drive.truths["kingpin_torque"]
    result = found[TWO_STAGE].result
    assert result is not None
    misses = (modelled_torque(p, drive) - truth, result["self_aligning_torque"] - truth)
    for name, away in zip(("eq (3)", "disturbance observer"), misses, strict=True):
        miss = float(np.sqrt(np.mean(away[within] ** 2)) / np.std(truth[within]))
        rows.append({"observer": name, "torque_miss": miss})
    return rows


def side_by_side(task: tuple[str, str, int]) -> list[Row]:
    """Two virtual cars steered by wire, with sensors every millisecond.

    The first has two tracks on Magic Formula tyres, whose forces lag behind the slip by a rolled distance of 0.4 m; the
    second has brush tyres (Fiala) that follow at once. Cornering stiffness and trail of the observers are matched to
    each car on slow circles at the speed of the test, because a curved tyre has no one stiffness. Model only: the
    single track driven by the measured steer. Torque inverted: eq (12) solved for the sideslip.
    """
    car, case, seed = task
    drive, factors = CASES[case]
    p = matched(car, drive.speed, drive.steer, drive.neutral)
    p = dataclasses.replace(p, **{name: factor * getattr(p, name) for name, factor in factors.items()})
    recorded = on(drive, car, seed)
    found = {name: error(course, recorded) for name, course in courses(p, recorded).items()}
    return [
        {"car": car, "case": case, "observer": name, "error": each, "over_model": each / found[MODEL]}
        for name, each in found.items()
    ]


class Poles(NamedTuple):
    """A drive of the car with brush tyres with poles of several speeds."""

    speed: float
    seed: int
    factors: tuple[float, ...]


def poles(task: Poles) -> list[Row]:
    """Poles are real, a factor times the size of the system's eigenvalues; the disturbance observer keeps its own."""
    drive = SLOW if task.speed == SLOW.speed else FAST
    p, recorded = matched("brush tyres", drive.speed, drive.steer), on(drive, "brush tyres", task.seed)
    rows: list[Row] = []
    for name, build in (("conventional", conventional_poles), ("two-stage", two_stage_poles)):
        errors = [error(observed(build(p, 1.0 / RATE, factor), recorded), recorded) for factor in task.factors]
        rows += [
            {"observer": name, "speed": drive.speed, "factor": factor, "error": each, "above_best": each - min(errors)}
            for factor, each in zip(task.factors, errors, strict=True)
        ]
    return rows


class Steady(NamedTuple):
    """Motion on a steady circle [rad], [rad/s]."""

    sideslip_angle: float
    yaw_rate: float


def steady(p: SingleTrack.Parameters, steer: float, speed: float, turned: bool) -> Steady:
    """Sideslip and yaw rate on a steady circle, in closed form, with or without the cosine of the steer in eq (6)."""
    share = math.cos(steer) if turned else 1.0
    front, rear = share * p.front_cornering_stiffness, p.rear_cornering_stiffness
    a, b, m = p.front_distance, p.rear_distance, p.mass
    matrix = [
        [-(front + rear), -m * speed - (a * front - b * rear) / speed],
        [-(a * front - b * rear), -(a * a * front + b * b * rear) / speed],
    ]
    found = np.linalg.solve(matrix, [-front * steer, -a * front * steer])
    return Steady(float(found[0]), float(found[1]))


WIDE = Drive(4.0, 20.0, 0.2)
TURNS = {"the paper's": SLOW, "25 m/s": FAST, "4 m/s, 20° at 0.2 Hz": WIDE}
"""Drives of the comparison of both forms of eq (6)."""


def cosine(task: tuple[str, str, int]) -> list[Row]:
    """Eq (6) has the cosine of the steer at the front force; eq (9) and all that follows take it as one.

    Moved: largest change of an error by it, of the model without feedback and of the conventional observer.
    """
    car, name, seed = task
    drive = TURNS[name]
    p, recorded = matched(car, drive.speed, drive.steer), on(drive, car, seed)
    models: tuple[Model, ...] = (SingleTrack, TurnedSingleTrack)
    alone = [error(Course(open_loop(model, p, recorded)), recorded) for model in models]
    blocks = (conventional_kalman(p, 1.0 / RATE), turned_kalman(p, 1.0 / RATE))
    fed = [error(observed(each, recorded), recorded) for each in blocks]
    moved = max(abs(alone[0] - alone[1]), abs(fed[0] - fed[1]))
    return [{"car": car, "drive": name, "model": alone[0], "observer": fed[0], "moved": moved}]


def turned_kalman(p: SteeredVehicle.Parameters, sample_time: float) -> ConventionalKalman:
    """The conventional observer with Kalman gains for eq (6) with the cosine of the steer angle."""
    plain = conventional_kalman(p, sample_time)
    model: Any = discretise(TurnedSteeredVehicle, "midpoint", finer_steps(sample_time))
    parameters = model.Parameters(plain.filter.parameters.continuous, sample_time)
    return dataclasses.replace(plain, filter=dataclasses.replace(plain.filter, model=model, parameters=parameters))


def limits(task: tuple[str, int]) -> list[Row]:
    """The virtual car at 6.7 m/s with upright kingpins, tyres that follow at once, or both.

    Tyres build up their force over a rolled distance, in some 60 ms there; no observer of the paper knows of it.
    Kingpins that lean inwards lift the car as it is steered; the matched trail takes that in.
    """
    name, seed = task
    car = changed_cars()[name]
    p, drive = matched_to(car, SLOW.speed, SLOW.steer), driven(car, SLOW.course(), seed)
    trail = 1e3 * (p.mechanical_trail + p.pneumatic_trail)
    found = courses(p, drive)
    return [{"car": name, "trail": trail, "observer": each, "error": error(found[each], drive)} for each in OBSERVERS]


def changed_cars() -> dict[str, Any]:
    """The virtual car as it is, and changed, by name."""
    car = virtual_car()
    chassis = car.chassis
    upright = dataclasses.replace(chassis.kingpins, inclination=0.0)
    axles = {}
    for name in ("front", "rear"):
        axle = getattr(chassis, name)
        axles[name] = dataclasses.replace(axle, tyre=dataclasses.replace(axle.tyre, lateral_relaxation=0.05))
    quick = dataclasses.replace(chassis, **axles)
    return {
        "as it is": car,
        "kingpins upright": dataclasses.replace(car, chassis=dataclasses.replace(chassis, kingpins=upright)),
        "tyres follow at once": dataclasses.replace(car, chassis=quick),
        "both": dataclasses.replace(car, chassis=dataclasses.replace(quick, kingpins=upright)),
    }


TYPICAL = (0.02, 0.2)
"""Typical magnitudes of sideslip angle [rad] and yaw rate [rad/s], by which states are scaled for the margin."""


def neutral_steer(task: tuple[float, float]) -> list[Row]:
    """Rank of observability, from the orthonormal staircase, for the car of the file with another rear axle.

    Ratio: its cornering stiffness over that with which the car neither understeers nor oversteers. The margin is the
    share of the sideslip in the yaw rate, for states of usual magnitude: a rank counts any non-zero direction.
    """
    ratio, speed = task
    p = from_file()
    rear = ratio * p.front_cornering_stiffness * p.front_distance / p.rear_distance
    car = dataclasses.replace(p, rear_cornering_stiffness=rear, road_wheel_friction=0.0)
    own = TorqueShownVehicle.Parameters(
        *(getattr(car, each.name) for each in dataclasses.fields(TorqueShownVehicle.Parameters))
    )
    vehicle = linearise(TorqueShownVehicle, own, (0.0, 0.0), (0.0, speed))
    steered = linearise(SteeredVehicle, car, (0.0,) * 4, (0.0, speed))
    systems = {
        "yaw rate": _only(vehicle, 0),
        "yaw rate and aligning torque": vehicle,
        "yaw rate and angle, steering modelled": steered,
        "angle alone, steering modelled": _only(steered, 1),
    }
    margin = float(observability(systems["yaw rate"], 1e-9, TYPICAL).singular_values[1])
    return [
        {"ratio": ratio, "speed": speed, "outputs": name, "rank": observability(each, 1e-9).rank, "margin": margin}
        for name, each in systems.items()
    ]


def _only(system: LinearSystem, output: int) -> LinearSystem:
    chosen = [output]
    return dataclasses.replace(system, C=system.C[chosen], D=system.D[chosen], outputs=(system.outputs[output],))
