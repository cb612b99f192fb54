"""Drives of the study as data: car, friction, road and sensors of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tierod.core.recording import Recording
from tierod_lab.ground import EpsCar, FrictionCourse, Scatter, SensorSet, TwoTrack, drive
from tierod_lab.ground.chassis.tyres import TYRES
from tierod_lab.ground.courses.course import Restlessness
from tierod_lab.ground.courses.roads import AnyRoad, City, Country, Motorway
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.steering.column_eps import WormGear
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DahlPower, LuGre, MaxwellSlip, Stribeck

HEALTHY = 4.0  # Friction of the fault-free steering [N*m]; Table 1 of the paper

STATES = {"Healthy": HEALTHY} | {"PWM 15%": 5.5, "PWM 20%": 8.0, "PWM 25%": 12.5}
"""Total friction of every health state [N*m]: the clutch brake adds the middle of every range in Table 1."""

RATIO_GROWTH = 0.06
"""Growth of the steering ratio with the squared angle [1/rad**2]: 15 % more direct at a quarter turn; assumed."""

_CARS = 77  # Number of the random stream that draws the cars; the first word of its seed is the car's


@dataclass(frozen=True)
class Setup:
    """A car with its sensors and roads."""

    car: EpsCar  # the true car, which the estimators do not have
    sensors: SensorSet  # sensors of the channels on its bus
    roads: tuple[AnyRoad, ...]  # kinds of road, in driving order


Change = Callable[[Setup], Setup]


def _steering(**changes: Any) -> Change:
    def change(setup: Setup) -> Setup:
        return replace(setup, car=replace(setup.car, steering=replace(setup.car.steering, **changes)))  # type: ignore[type-var]

    return change


def _friction(**changes: Any) -> Change:
    return lambda setup: _steering(friction=replace(setup.car.steering.friction, **changes))(setup)  # type: ignore[attr-defined]


def _noisy_rate(setup: Setup) -> Setup:
    rate = replace(setup.sensors["steering_wheel_rate"], noise=0.05)
    return replace(setup, sensors=setup.sensors.with_sensors({"steering_wheel_rate": rate}))


def _driven_fast(setup: Setup) -> Setup:
    roads = tuple(
        replace(road, lateral_acceleration=5.0, speed=(1.15 * road.speed[0], 1.15 * road.speed[1]))
        for road in setup.roads
    )
    return replace(setup, roads=roads)


def _more_direct(setup: Setup) -> Setup:
    linkage = replace(setup.car.steering.linkage, ratio_growth=RATIO_GROWTH)  # type: ignore[attr-defined]
    return _steering(linkage=linkage)(setup)


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
UNKNOWN_LAWS = tuple(LAWS)[4:]  # Laws that the default estimator does not assume: all but the first four of `LAWS`

USUAL, FAST, VARIABLE_RATIO = "as usual", "driven fast, 5 m/s²", "variable steering ratio"
CONDITIONS: Mapping[str, Change] = {
    USUAL: lambda setup: setup,
    "rate noise 0.05 rad/s": _noisy_rate,
    FAST: _driven_fast,
    VARIABLE_RATIO: _more_direct,
}

SCATTERS: Mapping[str, Scatter] = {
    "usual": Scatter(),
    "hard": Scatter(tyre_stiffness=0.1, mass=0.08, torque_delay=0.05),
}
"""Spread of car and sensors: as between cars of one type, and larger, with delayed torques."""


@dataclass(frozen=True)
class Case:
    """One drive."""

    route: int  # seed of road, driver and sensor noise
    friction: float | FrictionCourse = HEALTHY  # level of dry friction [N*m], or its course over time
    minutes: float = 13.0  # duration [min]
    # seed of the car and its sensors, drawn around the nominal ones; None for the nominal ones themselves
    car: int | None = None
    scatter: str = "usual"  # spread of car and sensors, a name in `SCATTERS`
    tyres: str = "summer"  # a name in `TYRES`
    law: str = "Dahl 1°"  # friction law, a name in `LAWS`
    condition: str = USUAL  # further difference from the usual drive, a name in `CONDITIONS`

    def setup(self) -> Setup:
        """Car, sensors and roads with tyres, law and condition applied, then drawn at random around them."""
        car = EpsCar()
        assert isinstance(car.chassis, TwoTrack)
        car = replace(car, chassis=car.chassis.on_tyres(TYRES[self.tyres]))
        setup = Setup(car, SensorSet.production().only(CHANNELS), (City(), Country(), Motorway()))
        setup = CONDITIONS[self.condition](LAWS[self.law](setup))
        if self.car is None:
            return setup
        car, sensors = SCATTERS[self.scatter].draw(setup.car, setup.sensors, np.random.default_rng([self.car, _CARS]))
        return replace(setup, car=car, sensors=sensors)

    def recording(self, with_motor: bool = False) -> Recording:
        """Simulate the drive; the channels are those of the sensors, and the truth.

        Args:
            with_motor: whether there are `pinion_angle` and `motor_speed`, as accurate at the column as the steering
                wheel's angle and rate
        """
        setup, conditions = self.setup(), (Restlessness(),)
        sensors = setup.sensors
        if with_motor:
            rate = sensors["steering_wheel_rate"]
            speed = replace(rate, noise=gear_of(setup.car) * rate.noise)
            sensors = sensors.with_sensors({"motor_speed": speed, "pinion_angle": sensors["steering_wheel_angle"]})
        how: dict[str, Any] = {"sensors": sensors, "roads": setup.roads, "conditions": conditions}
        return drive(setup.car, self.minutes, self.friction, seed=self.route, **how)


def gear_of(car: EpsCar) -> float:
    """Turns of the motor per turn of the column."""
    return float(car.steering.motor.ratio)  # type: ignore[attr-defined]
