"""Joint model of steering, yaw, self-aligning torque and friction, after Mohtat et al., equations (2) to (10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, exp
from tierod.models.steering_column import FrictionParameters
from tierod.physics.friction import share_reached
from tierod.physics.steering import column_torque_of_motor, torque_at_steering_wheel
from tierod_lab.ground.laws import smooth_coulomb


def driving_torque(driver_torque: Number, motor_torque: Number, self_aligning_torque: Number, p: Any) -> Number:
    """Torque on the column without friction and damping [N m]: T_d + n T_m - rho M_z of eq (2).

    Args: driver_torque: at the steering wheel [N m]; motor_torque: at the motor shaft [N m]; self_aligning_torque:
    about the kingpins, resisting [N m].
    """
    driven = driver_torque + column_torque_of_motor(motor_torque, p.motor_ratio)
    return driven - torque_at_steering_wheel(self_aligning_torque, p.steering_ratio)


def column_after(angle: Scalar, rate: Scalar, net_torque: Scalar, p: Any) -> tuple[Scalar, Scalar]:
    """Angle [rad] and rate [rad/s] of the steering wheel after one sample.

    Source: Mohtat et al., first two rows of eq (7); the angle is integrated by Euler's method as printed.

    Args: angle: of the steering wheel [rad]; rate: of the steering wheel [rad/s]; net_torque: on the column without
    damping, constant over the sample: `driving_torque` less dry friction [N m].
    """
    decay, gain = rate_hold(p.sample_time, p.column_damping, p.column_inertia)
    return angle + p.sample_time * rate, decay * rate + gain * net_torque


def rate_hold(sample_time: Scalar, damping: Scalar, inertia: Scalar) -> tuple[Scalar, Scalar]:
    """Decay of the rate over one sample, and rate gained per constant torque.

    Source: Mohtat et al., eqs (7) to (9), re-derived; `share_reached` keeps beta accurate for small dt B/J.

    Args: sample_time: dt [s]; damping: B_eq [N m s/rad], greater than zero; inertia: J_eq [kg m^2].

    Returns:
        (a, beta): a = exp(-dt B/J) [-], beta = (1 - a)/B [rad/s/(N m)]; beta is exact and contains dt
    """
    elapsed = sample_time * damping / inertia
    return exp(-elapsed), share_reached(elapsed) / damping


@dataclass(frozen=True)
class SmoothFrictionParameters(FrictionParameters):
    """Parameters of the model with smoothed friction."""

    # rate at which tanh reaches 76 % [rad/s]: 0.02 is sharp, 0.05 compensates for pre-sliding
    smoothing_rate: Annotated[float, "rad/s"] = 0.02


class FrictionEstimation:
    """Steering wheel, yaw, self-aligning torque and friction torque as one state, linear for a given direction.

    Self-aligning torque and friction are constant except for process noise, which belongs to the estimator.
    `direction` is sgn(theta'*) at the operating point (appendix B): of the latest measured rate (as printed), or of
    the a posteriori estimate; 0 while the steering sticks, which removes friction from the balance.

    Validity: vehicle_speed above about 3 m/s (below it tyre scrub adds to the self-aligning torque), lateral
    acceleration without the component of gravity on a banked road.
    Source: Mohtat et al., eqs (5) to (10), corrected: the third state is the yaw rate; a = exp(-dt B/J) and
    beta = (1 - a)/B are the exact zero-order hold; the angle, on which no other state depends, is integrated by Euler's
    method as printed.
    """

    class State(NamedTuple):
        """State vector x of eq (6)."""

        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]
        yaw_rate: Annotated[float, "rad/s"]
        self_aligning_torque: Annotated[float, "N*m"]
        friction_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        """Input vector u of eq (6), and the direction of motion at the operating point."""

        driver_torque: Annotated[float, "N*m"]
        motor_torque: Annotated[float, "N*m"]
        lateral_acceleration: Annotated[float, "m/s**2"]
        direction: Annotated[float, ""]

    class Output(NamedTuple):
        """Measurements, eq (10)."""

        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]
        yaw_rate: Annotated[float, "rad/s"]

    Parameters = FrictionParameters

    @staticmethod
    def transition(x: State, u: Input, p: FrictionParameters) -> State:
        """State after one sample, eqs (5) and (7) to (9) without noise."""
        return _transition(x, u, p, x.friction_torque * u.direction)

    @staticmethod
    def output(x: State, u: Input, p: FrictionParameters) -> Output:
        """Measurements, eq (10)."""
        return FrictionEstimation.Output(x.steering_wheel_angle, x.steering_wheel_rate, x.yaw_rate)


class SmoothFrictionEstimation:
    """The joint model with friction T_f tanh(theta'/eps) as a function of the state, for nonlinear estimators.

    The input `direction` has no effect: the direction is that of the state.

    Source: Mohtat et al., eqs (5) to (10) as in `FrictionEstimation`; eq (18) before its linearisation, smoothed.
    """

    State = FrictionEstimation.State
    Input = FrictionEstimation.Input
    Output = FrictionEstimation.Output
    Parameters = SmoothFrictionParameters

    @staticmethod
    def transition(
        x: FrictionEstimation.State, u: FrictionEstimation.Input, p: SmoothFrictionParameters
    ) -> FrictionEstimation.State:
        """State after one sample, eq (18) and the linear rows of eq (7)."""
        friction = smooth_coulomb(x.steering_wheel_rate, x.friction_torque, p.smoothing_rate)
        return _transition(x, u, p, friction)

    @staticmethod
    def output(
        x: FrictionEstimation.State, u: FrictionEstimation.Input, p: SmoothFrictionParameters
    ) -> FrictionEstimation.Output:
        """Measurements, eq (10)."""
        return FrictionEstimation.output(x, u, p)


def _transition(
    x: FrictionEstimation.State, u: FrictionEstimation.Input, p: FrictionParameters, friction: Scalar
) -> FrictionEstimation.State:
    net = driving_torque(u.driver_torque, u.motor_torque, x.self_aligning_torque, p) - friction
    return state_after(x, net, u.lateral_acceleration, p)


def state_after(
    x: FrictionEstimation.State,
    net: Annotated[Scalar, "N*m"],
    lateral_acceleration: Annotated[Scalar, "m/s**2"],
    p: FrictionParameters,
) -> FrictionEstimation.State:
    """The state after one sample, for a given net torque at the column.

    Source: Mohtat et al., eq (7); self-aligning torque and friction are random walks.
    """
    names = ("mass", "yaw_inertia", "front_distance", "rear_distance", "trail")
    known = {name: getattr(p, name) for name in names}
    yaw_acceleration = yaw_acceleration_from_aligning(x.self_aligning_torque, lateral_acceleration, **known)
    return FrictionEstimation.State(
        *column_after(x.steering_wheel_angle, x.steering_wheel_rate, net, p),
        x.yaw_rate + p.sample_time * yaw_acceleration,
        x.self_aligning_torque,
        x.friction_torque,
    )


def yaw_acceleration_from_aligning(
    self_aligning_torque: Scalar,
    lateral_acceleration: Scalar,
    *,
    mass: Scalar,
    yaw_inertia: Scalar,
    front_distance: Scalar,
    rear_distance: Scalar,
    trail: Scalar,
) -> Scalar:
    """Yaw acceleration [rad/s**2] from the self-aligning torque: eq (4) solved for the yaw acceleration.

    Source: Mohtat et al., third row of eq (7): psi'' = (L/(lp Iz)) Mz - (Lr m/Iz) ay.
    """
    wheelbase = front_distance + rear_distance
    front_moment = wheelbase / trail * self_aligning_torque
    return (front_moment - rear_distance * mass * lateral_acceleration) / yaw_inertia
