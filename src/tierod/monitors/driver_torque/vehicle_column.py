"""The column of a vehicle as its file gives it, with or without a gear, and the tuning that suits it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.steering_column import ColumnParameters
from tierod.models.steering_wheel import BelowBarParameters
from tierod.models.two_inertia_column import TwoInertiaParameters, without_gear
from tierod.monitors.driver_torque.tuning import ColumnTuning, linear_of
from tierod.vehicles import Vehicle

ROAD = replace(ColumnTuning(), disturbance_torque_walk=0.5, pinion_torque_noise=1.0, offset="motor_angle_mechanical")
"""Noises of a car on the road: rack and road turn the pinion without notice, and nobody has set the angles to zero."""


def column_of_vehicle(vehicle: Vehicle, sample_time: float | None = None) -> ColumnParameters | TwoInertiaParameters:
    """The column of a vehicle: with its gear where the file gives `gear_stiffness` and the rate follows it.

    Else it has two inertias. A file with a motor's inertia and no column's brings them as they are; of another one,
    what `column_inertia` and `column_damping` hold beyond the steering wheel turns with the motor.

    Args:
        vehicle: with one of these columns
        sample_time: at which the column must be followed; None: not asked [s]

    Raises:
        ParameterError: parameters are missing, or leave nothing below the bar
    """
    if "gear_stiffness" in vehicle:
        column = vehicle.parameters_for(ColumnParameters)
        return without_gear(column) if sample_time and gear_is_too_fast(vehicle, sample_time) else column
    if "motor_inertia" in vehicle and "column_inertia" not in vehicle:
        return _stiff(vehicle)
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


def gear_is_too_fast(vehicle: Vehicle, sample_time: float) -> bool:
    """Whether the column has a gear whose vibration samples would take for a slower one, and the rest has not.

    Args:
        vehicle: with or without a gear
        sample_time: [s]
    """
    if "gear_stiffness" not in vehicle:
        return False
    column = vehicle.parameters_for(ColumnParameters)
    whole, rest = (
        float(np.max(np.abs(np.linalg.eigvals(linear_of(each).A).imag))) for each in (column, without_gear(column))
    )
    return whole * sample_time >= math.pi > rest * sample_time


def _stiff(vehicle: Vehicle) -> TwoInertiaParameters:
    """A column whose gear has no spring in the file: it turns with the motor."""
    ratio, inertia = vehicle["motor_ratio"], vehicle["motor_inertia"]
    if "gear_inertia" in vehicle:
        inertia += vehicle["gear_inertia"] / ratio**2
    return TwoInertiaParameters(
        vehicle["steering_wheel_inertia"],
        vehicle["steering_wheel_damping"],
        vehicle["torsion_bar_stiffness"],
        ratio,
        inertia,
        vehicle["motor_damping"],
    )


def usual_tuning(vehicle: Vehicle) -> ColumnTuning:
    """That of a bench for a column with a gear that has no column inertia of a car, else that of the road."""
    return ROAD if "column_inertia" in vehicle else ColumnTuning()
