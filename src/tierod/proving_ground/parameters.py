"""Parameters of the virtual car: the truth, which no monitor may read.

Unless said otherwise a value is typical of a mid-size car with column assist; the paper of Mohtat et al. prints none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from tierod.physics.single_track import front_axle_load, understeer_gradient
from tierod.physics.tyre import parking_torque


@dataclass(frozen=True)
class Chassis:
    """Body and tyres of the single track; stiffness of an axle, trail and contact length of a wheel."""

    mass: Annotated[float, "kg"] = 1600.0
    yaw_inertia: Annotated[float, "kg*m**2"] = 2800.0
    front_distance: Annotated[float, "m"] = 1.14
    rear_distance: Annotated[float, "m"] = 1.69
    front_stiffness: Annotated[float, "N/rad"] = 110e3
    rear_stiffness: Annotated[float, "N/rad"] = 130e3
    adhesion: Annotated[float, ""] = 0.9
    relaxation_length: Annotated[float, "m"] = 0.3
    mechanical_trail: Annotated[float, "m"] = 0.025
    contact_half_length: Annotated[float, "m"] = 0.075  # a third of it is the pneumatic trail: 0.025 m
    tyre_pressure: Annotated[float, "Pa"] = 2.2e5

    @property
    def wheelbase(self) -> float:
        """Distance of the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def front_load(self) -> float:
        """Static load of the front axle [N]."""
        return front_axle_load(self.mass, self.front_distance, self.rear_distance)

    @property
    def rear_load(self) -> float:
        """Static load of the rear axle [N]."""
        return front_axle_load(self.mass, self.rear_distance, self.front_distance)

    @property
    def understeer_gradient(self) -> float:
        """Extra road-wheel angle per lateral acceleration [rad*s**2/m]."""
        return understeer_gradient(
            self.mass, self.front_distance, self.rear_distance, self.front_stiffness, self.rear_stiffness
        )

    @property
    def parking_torque(self) -> float:
        """Torque about both kingpins that turns the standing front wheels on the ground [N*m]."""
        return 2.0 * parking_torque(0.5 * self.front_load, self.adhesion, self.tyre_pressure)


@dataclass(frozen=True)
class TorsionBar:
    """An elastic bar between steering wheel and column; without it the column is rigid."""

    stiffness: Annotated[float, "N*m/rad"] = 140.0
    damping: Annotated[float, "N*m*s/rad"] = 0.05
    wheel_inertia: Annotated[float, "kg*m**2"] = 0.035


@dataclass(frozen=True)
class Steering:
    """Column, gear and motor, referred to the steering wheel's axis.

    `inertia` and `damping` are those of the whole: wheel, rotor and road wheels. Friction is dry (Dahl) at the column,
    its level comes from outside. The scrub of standing tyres is a Dahl friction too, relaxed by rolling.
    """

    inertia: Annotated[float, "kg*m**2"] = 0.10
    damping: Annotated[float, "N*m*s/rad"] = 0.8
    ratio: Annotated[float, ""] = 1.0 / 15.5
    ratio_growth: Annotated[float, "1/rad**2"] = 0.0
    motor_gear: Annotated[float, ""] = 20.0
    motor_lag: Annotated[float, "s"] = 0.005
    dahl_angle: Annotated[float, "rad"] = math.radians(1.0)
    dahl_exponent: Annotated[float, ""] = 1.0
    scrub_angle: Annotated[float, "rad"] = math.radians(30.0)  # about 2 degrees of twist at the road wheel
    scrub_fade_speed: Annotated[float, "m/s"] = 2.0


@dataclass(frozen=True)
class AssistMap:
    """Characteristic of the motor's help, see `tierod.physics.assist`.

    `lead_time` advances the torque of an elastic bar, as controllers do to keep the loop of bar and assist stable; with
    a rigid column it does nothing.
    """

    linear_gain: Annotated[float, ""] = 2.0
    quadratic_gain: Annotated[float, "1/(N*m)"] = 1.5
    dead_band: Annotated[float, "N*m"] = 0.0
    half_speed: Annotated[float, "m/s"] = 15.0
    maximum_torque: Annotated[float, "N*m"] = 60.0
    lead_time: Annotated[float, "s"] = 0.015


@dataclass(frozen=True)
class Driver:
    """A person who follows a road: previews its curvature, corrects the offset after a delay, and steers with arms.

    The arms are a spring and damper that pull the wheel towards an angle the muscles have reached; the muscles follow
    the wanted angle with a lag of second order, critically damped. After Pick and Cole, Vehicle System Dynamics 46
    (2008).

    Args:
        arm_stiffness: torque per angle between muscles and wheel
        arm_damping: torque per rate between muscles and wheel
        muscle_time: time constant of the muscles, twice in a row
        torque_limit: what the person can or will apply
        preview_time: how far ahead the offset from the road is judged
        anticipation: how early the road's curvature is steered, makes up for muscles and vehicle
        correction: share of the offset correction that the person makes; 0 does not look at the road's edge
        persistence: integral gain on the remaining angle error, for a person told to reach an angle
        delay_steps: reaction delay of the correction, in steps of the plant
        restlessness: standard deviation of small needless corrections
    """

    arm_stiffness: Annotated[float, "N*m/rad"] = 40.0
    arm_damping: Annotated[float, "N*m*s/rad"] = 2.0
    muscle_time: Annotated[float, "s"] = 0.08
    torque_limit: Annotated[float, "N*m"] = 15.0
    preview_time: Annotated[float, "s"] = 1.5
    anticipation: Annotated[float, "s"] = 0.25
    correction: Annotated[float, ""] = 1.0
    persistence: Annotated[float, "1/s"] = 0.0
    delay_steps: int = 150
    restlessness: Annotated[float, "rad"] = 0.025
