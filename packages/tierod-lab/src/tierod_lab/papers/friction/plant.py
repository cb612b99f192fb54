"""Validation of the virtual car: closed forms, energy balance, tyre curves, another simulator, real cars."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Heading, Item
from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.identification.hysteresis import HysteresisIdentification
from tierod_lab.ground import ColumnEps, EpsCar, TwoTrack, lock_to_lock, with_friction
from tierod_lab.ground.courses import Start
from tierod_lab.papers.friction.fleet import GOAL
from tierod_lab.papers.friction.plant_agreement import Agreement, commonroad_agreement, commonroad_tyre
from tierod_lab.papers.friction.plant_checks import STEP, energy_error, understeer_error, unresisted, yaw_gain_error
from tierod_lab.papers.friction.plant_recordings import ferrari_agreement, rav4_agreement
from tierod_lab.papers.real_data import NO_DATA, recorded

LEVELS = (4.0, 12.5)
SPEEDS = (10.0, 20.0, 30.0)
WEAVES = ((20.0, 0.035, 0.2), (20.0, 0.035, 0.5), (20.0, 0.035, 1.0), (30.0, 0.0185, 0.5))
"""Speed [m/s], road-wheel angle [rad] and frequency [Hz] of the weaves that run in both simulators."""

ABSENT = "The package commonroad-vehicle-models is not installed."


def items() -> Iterator[Item]:
    yield Heading(
        "The virtual car",
        (
            "What stands above was measured on a virtual car: two tracks with roll and load transfer, Magic Formula "
            "tyres, column EPS with torsion bar, dry friction and an assist unit, a driver, and the sensors of a "
            "production car. It shares formulas with the estimators and no model. The claims on it are closed forms, "
            "conservation of energy, published tyre curves, another simulator, and recordings of real cars.",
        ),
    )
    yield from _on_closed_forms()
    yield from _on_the_simulator()
    yield from _on_real_cars()


def _on_closed_forms() -> Iterator[Claim]:
    chassis = unresisted(TwoTrack())
    yield _claim(
        "yaw-gain",
        "The steady yaw gain is that of the closed form in the linear range.",
        max(abs(yaw_gain_error(chassis, speed)) for speed in SPEEDS),
        0.01,
        f"Largest relative error at {', '.join(f'{speed:g}' for speed in SPEEDS)} m/s.",
    )
    yield _claim(
        "understeer",
        "The understeer gradient is that of the closed form in the linear range.",
        abs(understeer_error(chassis)),
        0.01,
        "Relative error at 30 m/s.",
    )
    yield _claim(
        "energy",
        "No energy is lost or made: accelerating in a weave to the limit, then braking to standstill.",
        energy_error(),
        0.01,
        "Energy left unexplained over the energy turned into heat.",
    )
    yield _claim(
        "hysteresis-area",
        "The area of the hysteresis loop is the work of friction.",
        max(abs(_loop_friction(level) / level - 1.0) for level in LEVELS),
        0.01,
        f"Lock-to-lock turns on the hoist with {' and '.join(f'{level:g}' for level in LEVELS)} N·m, from the signals "
        "of the sensors and the true damping: largest relative error.",
    )
    returned, held = _returned(1.0), _returned(0.0)
    yield Claim(
        "plant.free-return",
        "Let go in a bend, the steering returns; without friction to the middle.",
        GOAL,
        None,
        held,
        at_most(0.05),
        "rad",
        f"Angle 6 s after letting go at 1 rad and 15 m/s, without friction; with 1 N·m {returned:.2f} rad.",
    )


def _loop_friction(level: float) -> float:
    """Friction from the area of a hysteresis loop, less the work of the true damping [N*m]."""
    steering = EpsCar().steering
    assert isinstance(steering, ColumnEps)
    motor, bar = steering.motor, steering.torsion_bar
    damping = steering.damping + motor.ratio**2 * motor.damping
    inertia = steering.column_inertia + motor.ratio**2 * motor.inertia + steering.linkage.inertia
    stiffness = math.inf if bar is None else bar.stiffness
    method = HysteresisIdentification(motor.ratio, inertia, damping, 0.0, torsion_bar_stiffness=stiffness)
    return method.identify(lock_to_lock(level, hoist=True), "hoist").friction_torque


def _claim(name: str, text: str, measured: float | None, goal: float, note: str, unit: str = "") -> Claim:
    return Claim(f"plant.{name}", text, GOAL, None, measured, at_most(goal), unit, note)


def _returned(friction: float) -> float:
    """Steering wheel angle 6 s after its release at 1 rad [rad]."""
    car = with_friction(replace(EpsCar(), start=Start(15.0)), friction)
    time = np.arange(round(9.0 / STEP)) * STEP
    held = np.where(time < 3.0, 1.0, 0.0)
    given: dict[str, Any] = {"demand.speed": 15.0, "demand.steering_wheel_angle": held, "demand.grip": held}
    ones = ("road.adhesion_left", "road.adhesion_right", "road.support")
    samples = [
        np.broadcast_to(given.get(name, 1.0 if name in ones or name.endswith(".gain") else 0.0), time.shape)
        for name, _ in leaves(skeleton(car.Sample))
    ]
    out = scan(car, np.column_stack(samples))
    (name,) = (name for name in out.names if name.endswith(".steering_wheel_angle"))
    return float(abs(out[name][-1]))


def _on_the_simulator() -> Iterator[Claim]:
    tyre = _or_none(_tyre_error)
    yield _claim(
        "tyre-curve",
        "The side force of the tyre is that of a published Magic Formula set.",
        tyre,
        1e-3,
        "Largest relative error over load and slip, set of the BMW 320i that CommonRoad prints."
        if tyre is not None
        else ABSENT,
    )
    found = _or_none(lambda: [commonroad_agreement(*weave) for weave in WEAVES])
    for name, words in (("yaw_rate", "yaw rate"), ("lateral_acceleration", "lateral acceleration")):
        yield _claim(
            f"simulator-{name.replace('_', '-')}",
            f"Beside another simulator with the same parameters and steer the {words} is the same.",
            None if found is None else max(getattr(each, name) for each in found),
            0.05,
            ABSENT
            if found is None
            else "Drift single track of commonroad-vehicle-models, weaves up to "
            f"{max(each.peak for each in found):.1f} m/s²; largest root mean square of the difference over that of the "
            "reference.",
        )


def _tyre_error() -> float:
    from tierod.physics.magic_formula import combined_forces, stiffness_per_load

    # Before the import: it raises `InputError` where the package is missing.
    tyre = commonroad_tyre()
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    from vehiclemodels.utils.tire_model import formula_lateral

    published, worst = parameters_vehicle2().tire, 0.0
    for load in (1500.0, 3000.0, 6000.0):
        stiffness = stiffness_per_load(load, tyre.nominal_load, tyre.cornering_stiffness, tyre.load_of_greatest)
        stiffnesses = (tyre.longitudinal_stiffness, stiffness)
        friction = (tyre.longitudinal_friction * tyre.friction, tyre.friction)
        for slip in (-0.3, -0.05, 0.01, 0.1, 0.4):
            # The slip angle of the published formula has the opposite sign.
            theirs, _ = formula_lateral(-slip, 0.0, load, published)
            ours = combined_forces((0.0, slip), stiffnesses, friction, load, tyre.shape, tyre.curvature).lateral
            worst = max(worst, abs(float(ours) / float(theirs) - 1.0))
    return worst


def _or_none(work: Callable[[], Any]) -> Any:
    """Result of work with the other simulator; None where it is not installed."""
    try:
        return work()
    except (InputError, ImportError):
        return None


def _on_real_cars() -> Iterator[Claim]:
    minute = _recorded(rav4_agreement, "rav4_highway_minute", "can.log", dbc="rav4", channel_map="rav4")
    yield _claim(
        "rav4-yaw-rate",
        "Steered as a recorded minute of a RAV4, the virtual car turns as the real one.",
        None if minute is None else math.degrees(minute.yaw_rate_error),
        0.3,
        NO_DATA if minute is None else "Root mean square of the difference in yaw rate.",
        "deg/s",
    )
    laps = _recorded(ferrari_agreement, "ferrari_250lm_race", "laps.parquet")
    yield Claim(
        "plant.ferrari-yaw-gain",
        "In the linear parts of race laps of a Ferrari 250 LM the yaw rate is that of the real car.",
        GOAL,
        None,
        None if laps is None else laps.gain,
        between(0.9, 1.1),
        "",
        NO_DATA
        if laps is None
        else "Spread of our yaw rate over the recorded one, in the half to which nothing was fitted.",
    )


def _recorded(judge: Callable[[Recording], Agreement], *parts: str, **how: Any) -> Agreement | None:
    """Agreement with a recording of a real car; None where it or its reader is missing."""
    found = recorded(*parts, **how)
    return None if found is None else judge(found)
