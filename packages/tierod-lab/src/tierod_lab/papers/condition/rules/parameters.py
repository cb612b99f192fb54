"""Vehicle parameters of the residuals, and the coefficients of a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod.models.single_track import SingleTrack
from tierod_lab.papers.condition.rules.stiff_rack import StiffRack


@dataclass(frozen=True)
class ResidualParameters:
    """Parameters of the vehicle, named as in its file.

    Args:
        mass: mass of the vehicle as driven
        yaw_inertia: moment of inertia about the vertical axis
        front_distance, rear_distance: distance from the centre of gravity to the axle
        front_cornering_stiffness, rear_cornering_stiffness: cornering stiffness of an axle, both tyres together
        track_width: distance between the rear wheels
        steering_ratio: road-wheel angle over column angle
        column_inertia: moment of inertia of all that turns with the column
        rack_stiffness, rack_damping: stiffness and damping of the rack
        rack_ratio: rack travel over column angle
        nominal_friction: dry friction of the fault-free steering at the column
        wheel_radius: dynamic rolling radius

    Source: Li, Frey, Gauterin, Table A1. There `i` is the inverse of the rack ratio, although eqs (1) to (3) need the
    ratio itself and eq (5) inverts it; the inertia is printed in a thousandth of its unit.
    """

    mass: Annotated[float, "kg", POSITIVE]
    yaw_inertia: Annotated[float, "kg*m**2", POSITIVE]
    front_distance: Annotated[float, "m", POSITIVE]
    rear_distance: Annotated[float, "m", POSITIVE]
    front_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
    rear_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
    track_width: Annotated[float, "m", POSITIVE]
    steering_ratio: Annotated[float, "", POSITIVE]
    column_inertia: Annotated[float, "kg*m**2", POSITIVE]
    rack_stiffness: Annotated[float, "N/m", NOT_NEGATIVE]
    rack_damping: Annotated[float, "N*s/m", NOT_NEGATIVE]
    rack_ratio: Annotated[float, "m/rad", POSITIVE]
    nominal_friction: Annotated[float, "N*m", NOT_NEGATIVE]
    wheel_radius: Annotated[float, "m", POSITIVE]

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def single_track(self) -> SingleTrack.Parameters:
        """Parameters of the single-track model."""
        return SingleTrack.Parameters(
            self.mass,
            self.yaw_inertia,
            self.front_distance,
            self.rear_distance,
            self.front_cornering_stiffness,
            self.rear_cornering_stiffness,
        )

    @property
    def rack(self) -> StiffRack.Parameters:
        """Parameters of the steering with a rigid rack."""
        return StiffRack.Parameters(
            self.column_inertia,
            self.rack_stiffness,
            self.rack_damping,
            self.rack_ratio,
            self.nominal_friction,
        )


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of the models of torque, tie-rod force, angle and drives, by least squares on fault-free drives.

    Args:
        angle, rate, acceleration: torque over angle, rate and acceleration of the steering, a1 to a3 of eq (11)
        friction: dry friction, with the sign of the rate
        cornering: torque over lateral acceleration; missing in eq (11), which holds without a tie-rod force only
        torque_offset: offset of the torque sensor
        per_mass, per_torque: a4 and a5 of eq (46)
        force_friction: dry friction of eq (46), with the sign of the rate
        force_offset: offset of the force sensor
        understeer: steer angle over speed times yaw rate, which eq (7) leaves out
        angle_offset: offset of the angle sensor
        inertia, resistance, drag, turning: force of the drives over longitudinal acceleration, constant, over squared
            speed, and over lateral acceleration times steer angle
    """

    angle: Annotated[float, "N*m/rad", ANY] = 0.0
    rate: Annotated[float, "N*m*s/rad", ANY] = 0.0
    acceleration: Annotated[float, "kg*m**2", ANY] = 0.0
    friction: Annotated[float, "N*m", ANY] = 0.0
    cornering: Annotated[float, "kg*m", ANY] = 0.0
    torque_offset: Annotated[float, "N*m", ANY] = 0.0
    per_mass: Annotated[float, "", ANY] = 0.0
    per_torque: Annotated[float, "1/m", ANY] = 0.0
    force_friction: Annotated[float, "N*m", ANY] = 0.0
    force_offset: Annotated[float, "N", ANY] = 0.0
    understeer: Annotated[float, "rad*s**2/m", ANY] = 0.0
    angle_offset: Annotated[float, "rad", ANY] = 0.0
    inertia: Annotated[float, "kg", ANY] = 0.0
    resistance: Annotated[float, "N", ANY] = 0.0
    drag: Annotated[float, "N*s**2/m**2", ANY] = 0.0
    turning: Annotated[float, "kg", ANY] = 0.0
