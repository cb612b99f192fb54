"""Column and rack as one body: a rack steering without the oscillation of its teeth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.physics.friction import smooth_coulomb
from tierod.physics.gear import column_balance


class StiffRack:
    """Column and rack that turn together, driven by a torque at the column against the tie rods.

    Validity: below some 100 Hz; the two bodies oscillate on their teeth at 666 Hz. The rack's 3 kg, which would add
    0.3 % to the inertia, are neglected. Source: Li, Frey, Gauterin, eq (2), its rows added with the rack's position as
    ratio times angle, as in eq (5) (printed inverted).
    """

    class State(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]

    class Output(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters:
        """Inertia, rack and friction.

        Args:
            column_inertia: of everything that turns with the column
            rack_stiffness: of the rack towards its centre
            rack_damping: of the rack
            rack_ratio: rack travel per turn of the column
            nominal_friction: dry friction of the fault-free steering at the column
            friction_width: rate at which the smoothed friction has 76 % of its level
        """

        column_inertia: Annotated[float, "kg*m**2"]
        rack_stiffness: Annotated[float, "N/m"]
        rack_damping: Annotated[float, "N*s/m"]
        rack_ratio: Annotated[float, "m/rad"]
        nominal_friction: Annotated[float, "N*m"]
        friction_width: Annotated[float, "rad/s"] = 0.2

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        left = column_balance(
            u.steering_shaft_torque,
            friction,
            u.tie_rod_force,
            x.steering_wheel_angle,
            x.steering_wheel_rate,
            p.rack_ratio,
            p.rack_stiffness,
            p.rack_damping,
        )
        return StiffRack.State(x.steering_wheel_rate, left / p.column_inertia)

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        return StiffRack.Output(x.steering_wheel_angle)
