"""The paper's observers of the sideslip on two virtual cars: its test, wrong parameters, poles, neutral steer."""

from __future__ import annotations

import dataclasses

import numpy as np

from tierod.models.linear import LinearSystem, linearise
from tierod.physics.motion import front_slip_speed
from tierod.physics.tyre import linear_lateral_force
from tierod_lab.ground import courses
from tierod_lab.methods.ranks import observability
from tierod_lab.papers.sideslip.drives import (
    CARS,
    FAST,
    MODEL,
    OBSERVERS,
    RATE,
    SLOW,
    Drive,
    Driven,
    driven,
    error,
    from_file,
    matched,
    observed,
    open_loop,
    virtual_car,
)
from tierod_lab.papers.sideslip.observers import LowSpeed, conventional_poles
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, TorqueShownVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_poles
from tierod_lab.studies.metrics import Row

CONVENTIONAL, TWO_STAGE = "conventional, poles x10", "two-stage, Kalman"
"""Observers that redraw the figures: conventional with the printed poles, two-stage with Kalman gains."""
STEERED = 9.0  # Time at which steering begins in the paper's test [s]
CASES: dict[str, tuple[Drive, dict[str, float]]] = {
    "6.7 m/s": (SLOW, {}),
    "25 m/s": (FAST, {}),
    "friction not compensated": (SLOW, {"road_wheel_friction": 0.0}),
    "pneumatic trail +50 %": (SLOW, {"pneumatic_trail": 1.5}),
    "friction not compensated, 25 m/s": (FAST, {"road_wheel_friction": 0.0}),
    "pneumatic trail +50 %, 25 m/s": (FAST, {"pneumatic_trail": 1.5}),
}
"""Drive, and factors of the parameters that the observers assume, by name; 8° at 0.25 Hz or 1.3° at 0.3 Hz."""


def paper_test(seed: int) -> Driven:
    """The test of the paper: from a stand to 6.7 m/s, then 8 degrees at 0.25 Hz and 6 degrees at 0.5 Hz."""
    return driven(virtual_car(), courses.load("sideslip-test"), seed)


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
    p, drive = matched("virtual car", SLOW), paper_test(seed)
    found = {name: observed(OBSERVERS[name](p, 1.0 / RATE), drive) for name in (CONVENTIONAL, TWO_STAGE)}
    rows: list[Row] = []
    for name, result in found.items():
        correlation = float(np.corrcoef(result["sideslip_angle"], drive.truths["sideslip_angle"])[0, 1])
        rows.append({"observer": name, "correlation": correlation, "error": error(result["sideslip_angle"], drive)})
    within, truth = drive.time > STEERED, drive.truths["kingpin_torque"]
    torques = {"eq (3)": modelled_torque(p, drive), "disturbance observer": found[TWO_STAGE]["self_aligning_torque"]}
    for name, torque in torques.items():
        miss = float(np.sqrt(np.mean((torque - truth)[within] ** 2)) / np.std(truth[within]))
        rows.append({"observer": name, "torque_miss": miss})
    return rows


def side_by_side(task: tuple[str, str, int]) -> list[Row]:
    """Two virtual cars steered by wire, with sensors every millisecond.

    The first has two tracks on Magic Formula tyres, whose forces lag behind the slip by a rolled distance of 0.4 m; the
    second has brush tyres (Fiala) that follow at once. Cornering stiffness and trail of the observers are matched to
    each car on slow circles at the speed of the test, because a curved tyre has no one stiffness. Model only: the
    single track driven by the measured steer.
    """
    car, case, seed = task
    drive, factors = CASES[case]
    p = matched(car, drive)
    p = dataclasses.replace(p, **{name: factor * getattr(p, name) for name, factor in factors.items()})
    recorded = driven(CARS[car](), drive.course(), seed)
    found = {MODEL: error(open_loop(p, recorded), recorded)}
    for name, build in OBSERVERS.items():
        found[name] = error(observed(build(p, 1.0 / RATE), recorded)["sideslip_angle"], recorded)
    return [
        {"car": car, "case": case, "observer": name, "error": each, "over_model": each / found[MODEL]}
        for name, each in found.items()
    ]


def poles(task: tuple[int, tuple[float, ...]]) -> list[Row]:
    """Poles are real, a factor times the size of the system's eigenvalues; the disturbance observer keeps its own.

    The car is that with brush tyres, at the speed of the paper's test.
    """
    seed, factors = task
    p, recorded = matched("brush tyres", SLOW), driven(CARS["brush tyres"](), SLOW.course(), seed)
    rows: list[Row] = []
    for name, build in (("conventional", conventional_poles), ("two-stage", two_stage_poles)):
        errors = [
            error(observed(build(p, 1.0 / RATE, factor), recorded)["sideslip_angle"], recorded) for factor in factors
        ]
        for factor, each in zip(factors, errors, strict=True):
            rows.append({"observer": name, "factor": factor, "error": each, "above_best": each - min(errors)})
    return rows


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
    }
    margin = float(observability(systems["yaw rate"], 1e-9, TYPICAL).singular_values[1])
    return [
        {"ratio": ratio, "speed": speed, "outputs": name, "rank": observability(each, 1e-9).rank, "margin": margin}
        for name, each in systems.items()
    ]


def _only(system: LinearSystem, output: int) -> LinearSystem:
    chosen = [output]
    return dataclasses.replace(system, C=system.C[chosen], D=system.D[chosen], outputs=(system.outputs[output],))
