"""The column of a vehicle as its file gives it, with or without a gear, and the tuning that suits it."""

from __future__ import annotations

from dataclasses import replace

from tierod.errors import ParameterError
from tierod.models.below_bar import BelowBarParameters
from tierod.models.steering_column import ColumnParameters
from tierod.models.two_inertia_column import TwoInertiaParameters
from tierod.monitors.driver_torque.tuning import ColumnTuning
from tierod.vehicles import Vehicle

ROAD = replace(ColumnTuning(), disturbance_torque_walk=0.5, pinion_torque_noise=1.0, offset="motor_angle_mechanical")
"""Noises of a car on the road: rack and road turn the pinion without notice, and nobody has set the angles to zero."""


def column_of_vehicle(vehicle: Vehicle) -> ColumnParameters | TwoInertiaParameters:
    """The column of a vehicle: with its gear where the file gives `gear_stiffness`, else of two inertias.

    Without a gear, what `column_inertia` and `column_damping` hold beyond the steering wheel turns with the motor.

    Raises:
        ParameterError: parameters are missing, or leave nothing below the bar
    """
    if "gear_stiffness" in vehicle:
        return vehicle.parameters_for(ColumnParameters)
    below = vehicle.parameters_for(BelowBarParameters)
    needed = ("steering_wheel_inertia", "torsion_bar_stiffness", "motor_ratio")
    for name in needed:
        vehicle[name]
    if below.inertia <= 0.0 or below.damping < 0.0:
        raise ParameterError(
            f"below the torsion bar of '{vehicle.name}' remain {below.inertia:g} kg m^2 and {below.damping:g} "
            "N m s/rad of column_inertia and column_damping; expected both larger than those of the steering wheel"
        )
    ratio = vehicle["motor_ratio"]
    return TwoInertiaParameters(
        below.steering_wheel_inertia,
        below.steering_wheel_damping,
        below.torsion_bar_stiffness,
        ratio,
        below.inertia / ratio**2,
        below.damping / ratio**2,
    )


def usual_tuning(vehicle: Vehicle) -> ColumnTuning:
    """That of a bench for a column with a gear that has no column inertia of a car, else that of the road."""
    return ROAD if "column_inertia" in vehicle else ColumnTuning()
