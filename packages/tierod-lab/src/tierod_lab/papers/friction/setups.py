"""Variations of car, sensors and roads in the study, by name: tyres, friction laws, conditions, scatter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tierod_lab.ground import EpsCar, Scatter, SensorSet, TwoTrack
from tierod_lab.ground.chassis.tyres import TYRES as KINDS_OF_TYRES
from tierod_lab.ground.courses.course import AnyCondition, Gusts, Restlessness, Unevenness
from tierod_lab.ground.courses.roads import AnyRoad, City, Country, Motorway
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.steering.column_eps import WormGear
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DahlPower, LuGre, MaxwellSlip, Stribeck


@dataclass(frozen=True)
class Setup:
    """A car with its sensors, roads and driving conditions."""

    car: EpsCar  # the true car, which the estimators do not have
    sensors: SensorSet  # sensors of the channels on its bus
    roads: tuple[AnyRoad, ...]  # kinds of road, in driving order
    conditions: tuple[AnyCondition, ...]  # disturbances by driver, wind and road
    # whether angle and rate of the steering wheel are measured at the motor, below the torsion bar
    below_bar: bool = False


Change = Callable[[Setup], Setup]


def usual() -> Setup:
    """The mid-size car on two tracks and summer tyres, with sensors of a production car, on mixed roads."""
    sensors = SensorSet.production().only(CHANNELS)
    return Setup(EpsCar(), sensors, (City(), Country(), Motorway()), (Restlessness(),))


def chassis(setup: Setup) -> TwoTrack:
    """Two-track chassis of the car.

    Raises:
        TypeError: the car has another chassis
    """
    if not isinstance(setup.car.chassis, TwoTrack):
        raise TypeError(f"the study drives cars on two tracks, not on {type(setup.car.chassis).__name__}")
    return setup.car.chassis


def _steering(**changes: Any) -> Change:
    def change(setup: Setup) -> Setup:
        return replace(setup, car=replace(setup.car, steering=replace(setup.car.steering, **changes)))  # type: ignore[type-var]

    return change


def _friction(**changes: Any) -> Change:
    return lambda setup: _steering(friction=replace(setup.car.steering.friction, **changes))(setup)  # type: ignore[attr-defined]


def _linkage(**changes: Any) -> Change:
    return lambda setup: _steering(linkage=replace(setup.car.steering.linkage, **changes))(setup)  # type: ignore[attr-defined]


def _kingpins(level: float) -> Change:
    def change(setup: Setup) -> Setup:
        linkage = setup.car.steering.linkage  # type: ignore[attr-defined]
        return _steering(linkage=replace(linkage, friction=replace(linkage.friction, level=level)))(setup)

    return change


def _motor(**changes: Any) -> Change:
    return lambda setup: _steering(motor=replace(setup.car.steering.motor, **changes))(setup)  # type: ignore[attr-defined]


def _return(**changes: Any) -> Change:
    def change(setup: Setup) -> Setup:
        assist = setup.car.assist
        assist = replace(assist, active_return=replace(assist.active_return, **changes))
        return replace(setup, car=replace(setup.car, assist=assist))

    return change


def _trail(factor: float) -> Change:
    def change(setup: Setup) -> Setup:
        body = chassis(setup)
        pins = replace(body.kingpins, mechanical_trail=body.kingpins.mechanical_trail * factor)
        tyre = replace(body.front.tyre, trail=body.front.tyre.trail * factor)
        body = replace(body, kingpins=pins, front=replace(body.front, tyre=tyre))
        return replace(setup, car=replace(setup.car, chassis=body))

    return change


def _loaded(setup: Setup) -> Setup:
    body = chassis(setup)
    body = replace(
        body,
        mass=1.25 * body.mass,
        yaw_inertia=1.3 * body.yaw_inertia,
        front_distance=body.front_distance + 0.15,
        rear_distance=body.rear_distance - 0.15,
    )
    return replace(setup, car=replace(setup.car, chassis=body))


def _sensors(names: tuple[str, ...], **changes: Any) -> Change:
    def change(setup: Setup) -> Setup:
        changed = {name: replace(setup.sensors[name], **changes) for name in names}
        return replace(setup, sensors=setup.sensors.with_sensors(changed))

    return change


def _driven(acceleration: float, haste: float) -> Change:
    """Bends up to a lateral acceleration [m/s**2], speeds multiplied by `haste`."""

    def change(setup: Setup) -> Setup:
        roads = tuple(
            replace(road, lateral_acceleration=acceleration, speed=(haste * road.speed[0], haste * road.speed[1]))
            for road in setup.roads
        )
        return replace(setup, roads=roads)

    return change


def _below_bar(setup: Setup) -> Setup:
    return replace(setup, below_bar=True)


def _rough(setup: Setup) -> Setup:
    roads = tuple(replace(road, superelevation=0.3, greatest_bank=0.1) for road in setup.roads)
    return replace(setup, roads=roads, conditions=(*setup.conditions, Gusts(deviation=4.0), Unevenness(deviation=0.01)))


def together(*changes: Change) -> Change:
    """A change that applies all given ones in order."""

    def change(setup: Setup) -> Setup:
        for each in changes:
            setup = each(setup)
        return setup

    return change


def _tyres(name: str) -> Change:
    return lambda setup: replace(setup, car=replace(setup.car, chassis=chassis(setup).on_tyres(KINDS_OF_TYRES[name])))


TYRES: Mapping[str, Change] = {name: _tyres(name) for name in KINDS_OF_TYRES}

LAWS: Mapping[str, Change] = {
    "Coulomb": _friction(law=Coulomb()),
    "Dahl 0.3°": _friction(law=Dahl(math.radians(0.3))),
    "Dahl 1°": _friction(law=Dahl(math.radians(1.0))),
    "Dahl 3°": _friction(law=Dahl(math.radians(3.0))),
    "Dahl, exponent 0.5": _friction(law=DahlPower(exponent=0.5)),
    "Dahl, exponent 2": _friction(law=DahlPower(exponent=2.0)),
    "LuGre": _friction(law=LuGre()),
    "Maxwell slip 3°": _friction(law=MaxwellSlip()),
    "Stribeck 20 %": _friction(law=Stribeck()),
    "load-dependent 40 %": _friction(load_share=0.4),
    "worm gear with 0.5° of lash": _steering(worm_gear=WormGear(play=math.radians(0.5))),
}

USUAL_LAW = "Dahl 1°"
UNKNOWN_LAWS = tuple(LAWS)[4:]  # Laws that the default estimator does not assume: all but the first four of `LAWS`

_TORQUES = ("driver_torque", "motor_torque")
_MOTION = ("yaw_rate", "lateral_acceleration")

RATIO_GROWTH = 0.06
"""Growth of the steering ratio with the squared angle [1/rad**2]: 15 % more direct at a quarter turn; assumed."""

VARIABLE_RATIO = "variable steering ratio"

CONDITIONS: Mapping[str, Change] = {
    "as usual": lambda setup: setup,
    "rate noise 0.05 rad/s": _sensors(("steering_wheel_rate",), noise=0.05),
    "driven fast, 5 m/s²": _driven(5.0, 1.15),
    "driven to the limit, 7 m/s²": _driven(7.0, 1.3),
    "kingpin friction 10 N·m": _kingpins(10.0),
    "kingpin friction 25 N·m": _kingpins(25.0),
    "assist motor 20 ms slower": _motor(lag=0.022),
    "no active return": _return(gain=0.0),
    "strong active return": _return(gain=3.0, rate_gain=3.0),
    "angle measured below the torsion bar": _below_bar,
    "angle below the bar, driven fast": together(_below_bar, _driven(5.0, 1.15)),
    "torques 50 ms late": _sensors(_TORQUES, delay=0.05),
    "torques 100 ms late": _sensors(_TORQUES, delay=0.1),
    "yaw and acceleration 100 ms late": _sensors(_MOTION, delay=0.1),
    "torques read 20 % high": _sensors(_TORQUES, gain=1.2),
    "trail 60 % longer": _trail(1.6),
    "trail 40 % shorter": _trail(0.6),
    "fully loaded": _loaded,
    "wind, ruts and banked bends": _rough,
    VARIABLE_RATIO: _linkage(ratio_growth=RATIO_GROWTH),
    "all together": together(
        _driven(7.0, 1.3),
        _kingpins(25.0),
        _trail(1.6),
        _rough,
        _sensors(_TORQUES, delay=0.05),
    ),
}

SCATTERS: Mapping[str, Scatter] = {
    "usual": Scatter(),
    "hard": Scatter(tyre_stiffness=0.1, mass=0.08, torque_delay=0.05),
}
"""Spread of car and sensors: as between cars of one type, and larger, with delayed torques."""
