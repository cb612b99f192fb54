"""Models of the steering column, and of the steering wheel above the torsion bar."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import Number, sign
from tierod.physics.friction import dahl_slope
from tierod.physics.steering import gear_coupling_torque, torsion_bar_torque


@dataclass(frozen=True)
class SteeringWheelParameters:
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
        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]
        hand_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        driver_torque: Annotated[float, "N*m"]
        steering_wheel_acceleration: Annotated[float, "rad/s**2"]

    class Output(NamedTuple):
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


@dataclass(frozen=True)
class FrictionParameters:
    """Parameters of the joint model, named as in a vehicle file.

    The model of the paper has no bar; estimators with one use `below_bar`.
    """

    mass: Annotated[float, "kg"]  # of the vehicle [kg]
    yaw_inertia: Annotated[float, "kg*m**2"]  # about the vertical axis [kg m^2]
    front_distance: Annotated[float, "m"]  # centre of gravity to front axle [m]
    rear_distance: Annotated[float, "m"]  # centre of gravity to rear axle [m]
    # mechanical and pneumatic trail together, l_p [m]; the paper mentions the pneumatic part only
    trail: Annotated[float, "m"]
    steering_ratio: Annotated[float, ""]  # road wheel angle per steering wheel angle, rho [-]
    column_inertia: Annotated[float, "kg*m**2"]  # J_eq at the steering wheel axis [kg m^2]
    column_damping: Annotated[float, "N*m*s/rad"]  # B_eq at the steering wheel axis [N m s/rad], greater than zero
    motor_ratio: Annotated[float, ""]  # turns of the motor per turn of the wheel, n [-]
    sample_time: Annotated[float, "s"] = 0.01  # dt [s]
    # parts of J_eq and B_eq above the torsion bar
    steering_wheel_inertia: Annotated[float, "kg*m**2"] = 0.0
    steering_wheel_damping: Annotated[float, "N*m*s/rad"] = 0.0
    # [N m/rad]; infinite for a rigid bar, as the model of the paper has it
    torsion_bar_stiffness: Annotated[float, "N*m/rad"] = math.inf

    @property
    def below_bar(self) -> BelowBarParameters:
        return BelowBarParameters(
            self.column_inertia,
            self.column_damping,
            self.steering_wheel_inertia,
            self.steering_wheel_damping,
            self.torsion_bar_stiffness,
        )


@dataclass(frozen=True)
class Actuator:
    """Actuator between the motor of a steer-by-wire steering and the road wheels.

    Source: Yih, Ryu, Gerdes, eqs (1) and (2).
    """

    motor_torque_constant: Annotated[float, "N*m/A"]  # torque of the motor per current, k_M
    gearhead_ratio: Annotated[float, ""]  # turns of the motor per turn of the pinion, r_g
    gearhead_efficiency: Annotated[float, ""]
    power_assist_factor: Annotated[float, ""]  # torque at the pinion over that of the actuator, r_p
    steering_ratio: Annotated[float, ""]  # road-wheel angle per pinion angle; the paper's r_s is its inverse

    def motor_torque(self, motor_current: Number) -> Number:
        """Torque at the motor's shaft [N*m] of a current [A]."""
        return self.motor_torque_constant * motor_current

    def road_wheel_torque(self, motor_torque: Number) -> Number:
        """Torque at the road wheels [N*m] of a torque at the motor's shaft [N*m]."""
        passed = self.gearhead_efficiency * self.gearhead_ratio * motor_torque
        return self.power_assist_factor * passed / self.steering_ratio


class ColumnInput(NamedTuple):
    motor_torque: Annotated[float, "N*m"]  # electromagnetic torque at the motor's shaft, T_M2
    hand_torque: Annotated[float, "N*m"]  # of the driver's hands on the steering wheel, T_driver
    # opposing torque at the motor's shaft, T_C: dry friction, torque from the rack
    disturbance_torque: Annotated[float, "N*m"]


class ColumnOutput(NamedTuple):
    """Measurements of a column; `driver_torque` is the torque in the torsion bar, positive towards left."""

    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle_mechanical: Annotated[float, "rad"]
    driver_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class ColumnParameters:
    """A column without rack and road, named as in a vehicle file."""

    steering_wheel_inertia: Annotated[float, "kg*m**2"]  # J_sw [kg m^2]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"]  # beta_sw, to the housing [N m s/rad]
    torsion_bar_stiffness: Annotated[float, "N*m/rad"]  # k_shaft [N m/rad]
    motor_ratio: Annotated[float, ""]  # turns of the motor per turn of the shaft, tau [-]
    gear_stiffness: Annotated[float, "N*m/rad"]  # between motor and gear, at the motor's shaft, k* [N m/rad]
    # of worm wheel and worm at the steering wheel axis, J_shaft + tau^2 J_worm [kg m^2]
    gear_inertia: Annotated[float, "kg*m**2"]
    motor_inertia: Annotated[float, "kg*m**2"]  # J_M2 [kg m^2]
    motor_damping: Annotated[float, "N*m*s/rad"]  # beta_M2 [N m s/rad]


class SteeringColumn:
    """Linear column: steering wheel, gear and motor, coupled by the torsion bar and an elastic gear.

    Validity: the gear has no backlash, the bar is within its stops; dry friction is an external disturbance. Source:
    Raffone, eqs (1) to (3) and (7). Corrected: the ratio belongs to the coupling torque in (2), whose sign in (3) is
    the restoring one; the third row of A holds k* tau and -(k_shaft + k* tau^2); y and C name the outputs in different
    orders, here in that of y. The torque of the bar is positive towards left here, as the driver feels it.
    """

    class State(NamedTuple):
        """Rates and angles of steering wheel, motor and gear, in the order of eq (7)."""

        steering_wheel_rate: Annotated[float, "rad/s"]
        motor_speed: Annotated[float, "rad/s"]
        gear_rate: Annotated[float, "rad/s"]
        steering_wheel_angle: Annotated[float, "rad"]
        motor_angle: Annotated[float, "rad"]
        gear_angle: Annotated[float, "rad"]

    Input = ColumnInput
    Output = ColumnOutput
    Parameters = ColumnParameters

    @staticmethod
    def derivative(x: State, u: ColumnInput, p: ColumnParameters) -> State:
        """Rates of the state, eqs (1) to (3), corrected."""
        bar = torsion_bar_torque(x.steering_wheel_angle, x.gear_angle, p.torsion_bar_stiffness)
        coupling = gear_coupling_torque(x.motor_angle, x.gear_angle, p.motor_ratio, p.gear_stiffness)
        wheel = u.hand_torque - bar - p.steering_wheel_damping * x.steering_wheel_rate
        motor = u.motor_torque - u.disturbance_torque - coupling - p.motor_damping * x.motor_speed
        return SteeringColumn.State(
            wheel / p.steering_wheel_inertia,
            motor / p.motor_inertia,
            (bar + p.motor_ratio * coupling) / p.gear_inertia,
            x.steering_wheel_rate,
            x.motor_speed,
            x.gear_rate,
        )

    @staticmethod
    def output(x: State, u: ColumnInput, p: ColumnParameters) -> ColumnOutput:
        bar = torsion_bar_torque(x.steering_wheel_angle, x.gear_angle, p.torsion_bar_stiffness)
        return ColumnOutput(x.steering_wheel_angle, x.motor_angle, bar)


@dataclass(frozen=True)
class ColumnWithFrictionParameters(ColumnParameters):
    motor_friction: Annotated[float, "N*m"]  # level, at the motor's shaft, T_c [N m]
    motor_friction_stiffness: Annotated[float, "N*m/rad"]  # initial stiffness of its build-up, sigma [N m/rad]


class ColumnWithFriction:
    """The column with Dahl's friction at the motor.

    Validity: as `SteeringColumn`. The friction is smooth except for a kink where the motor reverses. Source: Raffone,
    eqs (1) to (4), corrected as in `SteeringColumn`; (4) is exact for its exponent of one only.
    """

    class State(NamedTuple):
        steering_wheel_rate: Annotated[float, "rad/s"]
        motor_speed: Annotated[float, "rad/s"]
        gear_rate: Annotated[float, "rad/s"]
        steering_wheel_angle: Annotated[float, "rad"]
        motor_angle: Annotated[float, "rad"]
        gear_angle: Annotated[float, "rad"]
        normalised_friction: Annotated[float, ""]

    Input = ColumnInput
    Output = ColumnOutput
    Parameters = ColumnWithFrictionParameters

    @staticmethod
    def derivative(x: State, u: ColumnInput, p: ColumnWithFrictionParameters) -> State:
        """Rates of the state, eqs (1) to (4), corrected."""
        resisting = u.disturbance_torque + p.motor_friction * x.normalised_friction
        column = SteeringColumn.derivative(_column(x), u._replace(disturbance_torque=resisting), p)
        angle = p.motor_friction / p.motor_friction_stiffness
        slope = dahl_slope(x.normalised_friction, sign(x.motor_speed), angle)
        return ColumnWithFriction.State(*column, slope * x.motor_speed)

    @staticmethod
    def output(x: State, u: ColumnInput, p: ColumnWithFrictionParameters) -> ColumnOutput:
        return SteeringColumn.output(_column(x), u, p)


def _column(x: ColumnWithFriction.State) -> SteeringColumn.State:
    return SteeringColumn.State(*x[:6])


# Choices for the spring: torsion bar and gear in series, the bar alone, or their sum as printed
SPRINGS = ("series", "torsion bar", "printed")


@dataclass(frozen=True)
class TwoInertiaParameters:
    """A column without its gear, with the names of `ColumnParameters`."""

    steering_wheel_inertia: Annotated[float, "kg*m**2"]  # J_sw [kg m^2]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"]  # beta_sw [N m s/rad]
    # between steering wheel and motor, at the steering wheel axis, k_shaft_new [N m/rad]
    stiffness: Annotated[float, "N*m/rad"]
    motor_ratio: Annotated[float, ""]  # tau [-]
    motor_inertia: Annotated[float, "kg*m**2"]  # of motor and gear at the motor's shaft, J_M2_new [kg m^2]
    motor_damping: Annotated[float, "N*m*s/rad"]  # beta_M2 [N m s/rad]


class TwoInertiaColumn:
    """Steering wheel and motor on one spring: the column without the mode of its gear.

    Validity: below some 50 Hz; the mode of the gear, at 112 Hz in the paper's column, is neglected. Source: Raffone,
    eqs (12) and (13), with the torque of the spring as measured torque.
    """

    class State(NamedTuple):
        """State vector of eq (18) without its torques."""

        steering_wheel_rate: Annotated[float, "rad/s"]
        motor_speed: Annotated[float, "rad/s"]
        steering_wheel_angle: Annotated[float, "rad"]
        motor_angle: Annotated[float, "rad"]

    Input = ColumnInput
    Output = ColumnOutput
    Parameters = TwoInertiaParameters

    @staticmethod
    def derivative(x: State, u: ColumnInput, p: TwoInertiaParameters) -> State:
        """Rates of the state, eqs (12) and (13)."""
        spring = torsion_bar_torque(x.steering_wheel_angle, x.motor_angle / p.motor_ratio, p.stiffness)
        wheel = u.hand_torque - spring - p.steering_wheel_damping * x.steering_wheel_rate
        motor = u.motor_torque - u.disturbance_torque + spring / p.motor_ratio - p.motor_damping * x.motor_speed
        return TwoInertiaColumn.State(
            wheel / p.steering_wheel_inertia, motor / p.motor_inertia, x.steering_wheel_rate, x.motor_speed
        )

    @staticmethod
    def output(x: State, u: ColumnInput, p: TwoInertiaParameters) -> ColumnOutput:
        spring = torsion_bar_torque(x.steering_wheel_angle, x.motor_angle / p.motor_ratio, p.stiffness)
        return ColumnOutput(x.steering_wheel_angle, x.motor_angle, spring)


def without_gear(column: ColumnParameters, spring: str = "series") -> TwoInertiaParameters:
    """The two-inertia column of a column: the gear turns with the motor, and its inertia is the motor's.

    Source: Raffone, eqs (9) to (11). Corrected: two springs in series give 1/k = 1/k_shaft + 1/(k* tau^2). Args:
    spring: "series" keeps the compliance of the gear, and the frequency of the column within 1 %; "torsion bar" follows
    strictly from (9); "printed" adds k*/tau to the bar as in (11), which has no mechanical meaning and is harmless only
    while the gear stiffness is that at the motor's shaft.
    """
    if spring not in SPRINGS:
        raise ParameterError(f"spring is '{spring}'; expected {', '.join(SPRINGS)}")
    bar, gear = column.torsion_bar_stiffness, column.gear_stiffness
    stiffness = {
        "series": 1.0 / (1.0 / bar + 1.0 / (gear * column.motor_ratio**2)),
        "torsion bar": bar,
        "printed": bar + gear / column.motor_ratio,
    }[spring]
    return TwoInertiaParameters(
        column.steering_wheel_inertia,
        column.steering_wheel_damping,
        stiffness,
        column.motor_ratio,
        column.motor_inertia + column.gear_inertia / column.motor_ratio**2,
        column.motor_damping,
    )
