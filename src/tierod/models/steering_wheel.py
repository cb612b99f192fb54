"""The steering split at the torsion bar that measures: the wheel above it, in the hands, and what is below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple


@dataclass(frozen=True)
class SteeringWheelParameters:
    """A steering wheel and the torque of the hands on it.

    Args:
        steering_wheel_inertia: J_sw [kg m^2]
        steering_wheel_damping: beta_sw, to the housing [N m s/rad]
        torque_offset: that the measured torque of the bar has too much [N m]
        inertia_error: inertia that the wheel has beyond J_sw [kg m^2]
        correlation_time: after which the hands' torque has changed [s]
    """

    steering_wheel_inertia: Annotated[float, "kg*m**2"]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"]
    torque_offset: Annotated[float, "N*m"] = 0.0
    inertia_error: Annotated[float, "kg*m**2"] = 0.0
    correlation_time: Annotated[float, "s"] = 0.1


class SteeringWheel:
    """A steering wheel between the measured torque of the bar and the unknown one of the hands.

    Nothing below the torsion bar enters, so that gear, motor, rack and road need not be known. An error of the inertia
    acts through an acceleration that is given: through that of the model, a filter would correlate it with the noise of
    the measured torque and learn an inertia that grows without end.
    Validity: a balanced wheel, or one that turns little; the torque of the hands wanders and returns to zero.
    Source: Raffone, eq (1), with T_driver as a first-order Gauss-Markov process.
    """

    class State(NamedTuple):
        """Motion of the wheel, and what turns it from outside."""

        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]
        hand_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        """Measured torque of the bar, positive towards left; and acceleration of the wheel, known from the past."""

        driver_torque: Annotated[float, "N*m"]
        steering_wheel_acceleration: Annotated[float, "rad/s**2"]

    class Output(NamedTuple):
        """Measurement of the angle sensor."""

        steering_wheel_angle: Annotated[float, "rad"]

    Parameters = SteeringWheelParameters

    @staticmethod
    def derivative(x: State, u: Input, p: SteeringWheelParameters) -> State:
        """Rate of change of the state."""
        bar = u.driver_torque - p.torque_offset
        torque = x.hand_torque - bar - p.steering_wheel_damping * x.steering_wheel_rate
        torque = torque - p.inertia_error * u.steering_wheel_acceleration
        return SteeringWheel.State(
            x.steering_wheel_rate, torque / p.steering_wheel_inertia, -x.hand_torque / p.correlation_time
        )

    @staticmethod
    def output(x: State, u: Input, p: SteeringWheelParameters) -> Output:
        """The angle."""
        return SteeringWheel.Output(x.steering_wheel_angle)


@dataclass(frozen=True)
class BelowBarParameters:
    """Constants of the steering, named as in a vehicle file, split at the torsion bar.

    The torque in the bar turns what is below it; inertia and damping of the steering wheel are the hands' to overcome.

    Args:
        column_inertia: of everything, at the steering wheel axis [kg m^2]
        column_damping: of everything, at the steering wheel axis [N m s/rad]
        steering_wheel_inertia: part of it above the bar [kg m^2]
        steering_wheel_damping: part of it above the bar [N m s/rad]
        torsion_bar_stiffness: [N m/rad]; infinite for a rigid bar
    """

    column_inertia: Annotated[float, "kg*m**2"]
    column_damping: Annotated[float, "N*m*s/rad"]
    steering_wheel_inertia: Annotated[float, "kg*m**2"] = 0.0
    steering_wheel_damping: Annotated[float, "N*m*s/rad"] = 0.0
    torsion_bar_stiffness: Annotated[float, "N*m/rad"] = math.inf

    @property
    def inertia(self) -> float:
        """Below the bar [kg m^2]."""
        return self.column_inertia - self.steering_wheel_inertia

    @property
    def damping(self) -> float:
        """Below the bar [N m s/rad]."""
        return self.column_damping - self.steering_wheel_damping
