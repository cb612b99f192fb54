"""Vehicle parameters of the residuals, and the coefficients of a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod.models.single_track import SingleTrack
from tierod.models.stiff_rack import StiffRack


@dataclass(frozen=True)
class ResidualParameters:
    """The vehicle, by the names of its file.

    Args:
        mass: as driven
        yaw_inertia: about the vertical axis
        front_distance, rear_distance: from the centre of gravity to the axles
        front_cornering_stiffness, rear_cornering_stiffness: of an axle, both tyres together
        track_width: between the rear wheels
        steering_ratio: road-wheel angle per turn of the column
        column_inertia: of all that turns with the column
        rack_stiffness, rack_damping: of the rack
        rack_ratio: rack travel per turn of the column
        nominal_friction: dry friction of the fault-free steering at the column
        wheel_radius: dynamic rolling radius

    Source: Li, Frey, Gauterin, Table A1. There `i` is the inverse of the rack ratio although eqs (1) to (3) need the
    ratio itself and eq (5) turns it round; the inertia is printed in a thousandth of its unit.
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
        """Between the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def single_track(self) -> SingleTrack.Parameters:
        """Parameters of the lateral motion."""
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
        """Parameters of the steering."""
        return StiffRack.Parameters(
            self.column_inertia,
            self.rack_stiffness,
            self.rack_damping,
            self.rack_ratio,
            self.nominal_friction,
        )


@dataclass(frozen=True)
class Coefficients:
    """Coefficients by least squares on fault-free drives for the models of torque, force and angle.

    Args:
        angle, rate, acceleration: of the steering, a1 to a3 of eq (11)
        friction: torque with the sign of the rate
        cornering: torque per lateral acceleration; missing in eq (11), which holds without a tie-rod force only
        torque_offset: of the sensor
        per_mass, per_torque: a4 and a5 of eq (46)
        force_friction: dry friction of eq (46), with the sign of the rate
        force_offset: of the sensor
        understeer: steer per speed and yaw rate, which eq (7) leaves out
        angle_offset: of the sensor
        inertia, resistance, drag, turning: force of the drives by longitudinal acceleration, at rest, per squared
            speed, and per lateral acceleration and steer
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
