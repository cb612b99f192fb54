"""Drives of the study as data: car, friction, road and sensors of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.recording import Recording
from tierod_lab.ground import FrictionCourse, SensorSet, drive
from tierod_lab.papers.friction.setups import CONDITIONS, LAWS, SCATTERS, TYRES, USUAL_LAW, Setup, usual

HEALTHY = 4.0  # Friction of the fault-free steering [N*m]; Table 1 of the paper

ADDED = {"PWM 15%": 1.5, "PWM 20%": 4.0, "PWM 25%": 8.5}
"""Friction that the paper's clutch brake adds [N*m]: middle of every range in Table 1."""

STATES = {"Healthy": HEALTHY} | {name: HEALTHY + added for name, added in ADDED.items()}
"""Total friction of every health state [N*m]."""

_CARS = 77  # Number of the random stream that draws the cars; the first word of its seed is the car's


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
    law: str = USUAL_LAW  # friction law, a name in `LAWS`
    condition: str = "as usual"  # further difference from the usual drive, a name in `CONDITIONS`
    # fault-free drive of the same car, which gives the baseline; None learns it in this drive
    reference: Case | None = None

    def __post_init__(self) -> None:
        named: tuple[tuple[Mapping[str, object], str], ...] = (
            (TYRES, self.tyres),
            (LAWS, self.law),
            (CONDITIONS, self.condition),
            (SCATTERS, self.scatter),
        )
        for names, name in named:
            if name not in names:
                raise ParameterError(f"the study does not know '{name}'{nearest(name, names)}")

    @property
    def level(self) -> float:
        """Friction level at the start of the drive [N*m]."""
        return self.friction.levels[0] if isinstance(self.friction, FrictionCourse) else self.friction

    def counted_from(self, first: int) -> Case:
        """The same case with the seeds of route, car and reference shifted by `first`; unchanged for 0."""
        if not first:
            return self
        reference = None if self.reference is None else self.reference.counted_from(first)
        car = None if self.car is None else first + self.car
        return replace(self, route=first + self.route, car=car, reference=reference)

    def setup(self) -> Setup:
        """Car, sensors and roads with tyres, law and condition applied, then drawn at random around them."""
        setup = usual()
        for change in (TYRES[self.tyres], LAWS[self.law], CONDITIONS[self.condition]):
            setup = change(setup)
        if self.car is None:
            return setup
        car, sensors = SCATTERS[self.scatter].draw(setup.car, setup.sensors, np.random.default_rng([self.car, _CARS]))
        return replace(setup, car=car, sensors=sensors)

    def recording(self) -> Recording:
        """Simulates the drive; the channels are those of the sensors, and the truth."""
        setup = self.setup()
        recording = drive(
            setup.car,
            self.minutes,
            self.friction,
            seed=self.route,
            sensors=_with_motor(setup) if setup.below_bar else setup.sensors,
            roads=setup.roads,
            conditions=setup.conditions,
        )
        return _column_angle_of_motor(recording, setup) if setup.below_bar else recording


def _with_motor(setup: Setup) -> SensorSet:
    """The sensors with those of the motor, which are as accurate at the column as the steering wheel's."""
    gear = setup.car.steering.motor.ratio  # type: ignore[attr-defined]
    rate = setup.sensors["steering_wheel_rate"]
    motor = {
        "motor_speed": replace(rate, noise=gear * rate.noise),
        "pinion_angle": setup.sensors["steering_wheel_angle"],
    }
    return setup.sensors.with_sensors(motor)


def _column_angle_of_motor(recording: Recording, setup: Setup) -> Recording:
    """The recording with angle and rate of the column, measured at the motor, in place of the steering wheel's."""
    gear = setup.car.steering.motor.ratio  # type: ignore[attr-defined]
    angle, speed = recording["pinion_angle"], recording["motor_speed"]
    below = {
        "steering_wheel_angle": replace(angle, name="steering_wheel_angle"),
        "steering_wheel_rate": replace(speed, name="steering_wheel_rate", values=speed.values / gear),
    }
    return replace(recording, channels={**recording.channels, **below})
