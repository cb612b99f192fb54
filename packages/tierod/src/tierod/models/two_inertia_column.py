"""The column without its gear: steering wheel and motor as two inertias on one spring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.errors import ParameterError
from tierod.models.steering_column import ColumnInput, ColumnOutput, ColumnParameters
from tierod.physics.steering_ratio import torsion_bar_torque

SPRINGS = ("series", "torsion bar", "printed")
"""Choices for the spring: torsion bar and gear in series, the bar alone, or their sum as printed."""


@dataclass(frozen=True)
class TwoInertiaParameters:
    """A column without its gear, with the names of `ColumnParameters`.

    Args:
        steering_wheel_inertia: J_sw [kg m^2]
        steering_wheel_damping: beta_sw [N m s/rad]
        stiffness: between steering wheel and motor, at the steering wheel axis, k_shaft_new [N m/rad]
        motor_ratio: tau [-]
        motor_inertia: of motor and gear at the motor's shaft, J_M2_new [kg m^2]
        motor_damping: beta_M2 [N m s/rad]
    """

    steering_wheel_inertia: Annotated[float, "kg*m**2"]
    steering_wheel_damping: Annotated[float, "N*m*s/rad"]
    stiffness: Annotated[float, "N*m/rad"]
    motor_ratio: Annotated[float, ""]
    motor_inertia: Annotated[float, "kg*m**2"]
    motor_damping: Annotated[float, "N*m*s/rad"]


class TwoInertiaColumn:
    """Steering wheel and motor on one spring: the column without the mode of its gear.

    Validity: below some 50 Hz; the mode of the gear, at 112 Hz in the paper's column, is neglected.
    Source: Raffone, eqs (12) and (13), with the torque of the spring as measured torque.
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

    Args:
        spring: "series" keeps the compliance of the gear, and the frequency of the column within 1 %; "torsion bar"
            follows strictly from (9); "printed" adds k*/tau to the bar as in (11), which has no mechanical meaning and
            is harmless only while the gear stiffness is that at the motor's shaft

    Raises:
        ParameterError: another spring

    Source: Raffone, eqs (9) to (11). Corrected: two springs in series give 1/k = 1/k_shaft + 1/(k* tau^2).
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
