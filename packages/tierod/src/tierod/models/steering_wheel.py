"""The steering split at the torsion bar: the steering wheel above it, and the parts below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple


@dataclass(frozen=True)
class SteeringWheelParameters:
    """A steering wheel and the torque of the hands on it."""

    steering_wheel_inertia: Annotated[float, "kg*m**2"]  # J_sw [kg m^2]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"]  # beta_sw, to the housing [N m s/rad]
    torque_offset: Annotated[float, "N*m"] = 0.0  # of the measured torque of the bar [N m]
    inertia_error: Annotated[float, "kg*m**2"] = 0.0  # true inertia of the wheel less J_sw [kg m^2]
    correlation_time: Annotated[float, "s"] = 0.1  # of the hands' torque [s]


class SteeringWheel:
    """A steering wheel under the measured torque of the bar and the unknown torque of the hands.

    The parts below the torsion bar do not enter, so that gear, motor, rack and road need not be known. An error of the
    inertia acts through a given acceleration: with that of the model, a filter would correlate it with the noise of the
    measured torque, and the estimated inertia would grow without bound.
    Validity: a balanced wheel, or one that turns little; the torque of the hands varies about zero.
    Source: Raffone, eq (1), with T_driver as a first-order Gauss-Markov process.
    """

    class State(NamedTuple):
        """Motion of the wheel, and torque of the hands."""

        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]
        hand_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        """Measured torque of the bar, positive towards left, and acceleration of the wheel from past samples."""

        driver_torque: Annotated[float, "N*m"]
        steering_wheel_acceleration: Annotated[float, "rad/s**2"]

    class Output(NamedTuple):
        """Measurement of the angle sensor."""

        steering_wheel_angle: Annotated[float, "rad"]

    Parameters = SteeringWheelParameters

    @staticmethod
    def derivative(x: State, u: Input, p: SteeringWheelParameters) -> State:
        bar = u.driver_torque - p.torque_offset
        torque = x.hand_torque - bar - p.steering_wheel_damping * x.steering_wheel_rate
        torque = torque - p.inertia_error * u.steering_wheel_acceleration
        return SteeringWheel.State(
            x.steering_wheel_rate, torque / p.steering_wheel_inertia, -x.hand_torque / p.correlation_time
        )

    @staticmethod
    def output(x: State, u: Input, p: SteeringWheelParameters) -> Output:
        return SteeringWheel.Output(x.steering_wheel_angle)


@dataclass(frozen=True)
class BelowBarParameters:
    """Constants of the steering, named as in a vehicle file, split at the torsion bar.

    The torque in the bar moves the parts below it; the hands overcome inertia and damping of the steering wheel.
    """

    column_inertia: Annotated[float, "kg*m**2"]  # total, at the steering wheel axis [kg m^2]
    column_damping: Annotated[float, "N*m*s/rad"]  # total, at the steering wheel axis [N m s/rad]
    steering_wheel_inertia: Annotated[float, "kg*m**2"] = 0.0  # part above the bar [kg m^2]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"] = 0.0  # part above the bar [N m s/rad]
    torsion_bar_stiffness: Annotated[float, "N*m/rad"] = math.inf  # [N m/rad]; infinite for a rigid bar

    @property
    def inertia(self) -> float:
        """Inertia below the bar [kg m^2]."""
        return self.column_inertia - self.steering_wheel_inertia

    @property
    def damping(self) -> float:
        """Damping below the bar [N m s/rad]."""
        return self.column_damping - self.steering_wheel_damping
