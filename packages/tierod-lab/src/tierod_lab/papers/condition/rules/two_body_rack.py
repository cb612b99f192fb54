"""Column and rack as two bodies coupled by their teeth, as in the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.physics.friction import smooth_coulomb
from tierod.physics.gear import lash_torque
from tierod_lab.papers.condition.rules.stiff_rack import StiffRack


class TwoBodyRack:
    """Column and rack with four states, driven by a torque at the column against the tie rods.

    Validity: any frequency, if the sampling is fast enough for the oscillation of the teeth (666 Hz with Table A1).
    Source: Li, Frey, Gauterin, eqs (2) to (4). There `i` must be the rack's travel per angle, and the first row lacks
    it before the force of the teeth; eq (3) is correct.
    """

    class State(NamedTuple):
        rack_position: Annotated[float, "m"]
        steering_wheel_angle: Annotated[float, "rad"]
        rack_speed: Annotated[float, "m/s"]
        steering_wheel_rate: Annotated[float, "rad/s"]

    Input = StiffRack.Input

    class Output(NamedTuple):
        rack_position: Annotated[float, "m"]
        steering_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters(StiffRack.Parameters):
        """Parameters of `StiffRack`, mass of the rack, and teeth between column and rack; defaults from Table A1.

        Args:
            rack_mass: of the rack, m_R
            tooth_stiffness, tooth_damping: of the teeth at the rack, k_TT and d_TT
        """

        rack_mass: Annotated[float, "kg"] = 3.0
        tooth_stiffness: Annotated[float, "N/m"] = 1e8
        tooth_damping: Annotated[float, "N*s/m"] = 1e3

    @staticmethod
    def derivative(x: State, u: StiffRack.Input, p: Parameters) -> State:
        travel = p.rack_ratio
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        twist = travel * x.steering_wheel_angle - x.rack_position
        teeth = lash_torque(
            twist, travel * x.steering_wheel_rate - x.rack_speed, p.tooth_stiffness, p.tooth_damping, 0.0
        )
        centring = p.rack_stiffness * x.rack_position + p.rack_damping * x.rack_speed
        return TwoBodyRack.State(
            x.rack_speed,
            x.steering_wheel_rate,
            (teeth - centring - u.tie_rod_force) / p.rack_mass,
            (u.steering_shaft_torque - friction - travel * teeth) / p.column_inertia,
        )

    @staticmethod
    def output(x: State, u: StiffRack.Input, p: Parameters) -> Output:
        return TwoBodyRack.Output(x.rack_position, x.steering_wheel_angle)
