"""Noises and ranges of the filter of every fault hypothesis for the whole vehicle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import e, hypot, log, pi, sqrt
from typing import Annotated

from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.signals import (
    ACCELERATION_NOISE,
    ACCELERATIONS,
    OF_AUTOMATED,
    OF_CARS,
    SENSOR_TABLE,
    SENSORS,
    Measured,
    Readings,
)
from tierod.vehicles import Vehicle
from tierod.vehicles.uncertain import held_deviation

SENSOR_NOISE = Measured(
    *(each.noise for each in SENSOR_TABLE if each.name in OF_AUTOMATED), *(ACCELERATION_NOISE,) * len(ACCELERATIONS)
)
"""Standard deviation of one reading of every sensor [unit of the sensor]."""
PLAUSIBLE = Readings(*(each.plausible for each in SENSOR_TABLE))
"""Width of the range in which a failed sensor may read [unit of the sensor], with the uniform density 1 / width."""
TORQUE_JUMP = 0.45
"""Standard deviation of the effect of a jump of the requested steering torque, as a share of the jump [-]; its time
between two samples is unknown."""


@dataclass(frozen=True)
class ModelError:
    """Standard deviations of the model error; since some grow with the forces, all thresholds adapt to the motion.

    Args:
        acceleration: longitudinal acceleration, white, per sample
        lateral_acceleration: lateral acceleration, white, per sample
        yaw_acceleration: yaw acceleration, white, per sample
        slip: deflection of the tyres as a slip, white, per sample
        steering_torque: torque of both motors, white, per sample
        friction_share: share of the column's friction, white, per sample
        force, force_share: lasting error of an axle force: at small force, and its growth with the force
        tie_rod, tie_rod_share: lasting error of the tie-rod force: at small force, and its growth with the force
        standing: additional error of the tie-rod force at standstill, where the tyres twist on the spot
        loss: lost share of a suspected actuator's torque
        yaw_rate_offset, angle_offset, wheel_speed_difference: deviations from a calibration
        wheel_speed_scale, drive_excess: the same as shares, since load and tyres change after a calibration
        wheel_speed_scale_alone: the same without the yaw rate or a wheel: the scale is then observable only by the
            lateral acceleration, which body roll changes by some percent
        drive_excess_alone: the same with a suspected drive: half the torque lost on one side looks like a quarter on
            both
        road: acceleration by grade or bank of the road
    """

    acceleration: Annotated[float, "m/s**2"] = 0.12
    lateral_acceleration: Annotated[float, "m/s**2"] = 0.12
    yaw_acceleration: Annotated[float, "rad/s**2"] = 0.08
    slip: Annotated[float, ""] = 1e-4
    steering_torque: Annotated[float, "N*m"] = 0.08
    friction_share: Annotated[float, ""] = 0.012
    force: Annotated[float, "N"] = 15.0
    force_share: Annotated[float, ""] = 0.035
    tie_rod: Annotated[float, "N"] = 6.0
    tie_rod_share: Annotated[float, ""] = 0.035
    standing: Annotated[float, "N"] = 150.0
    loss: Annotated[float, ""] = 0.7
    yaw_rate_offset: Annotated[float, "rad/s"] = 0.0007
    angle_offset: Annotated[float, "rad"] = 0.002
    wheel_speed_difference: Annotated[float, ""] = 0.0005
    wheel_speed_scale: Annotated[float, ""] = 0.05
    wheel_speed_scale_alone: Annotated[float, ""] = 0.003
    drive_excess: Annotated[float, ""] = 0.06
    drive_excess_alone: Annotated[float, ""] = 0.01
    road: Annotated[float, "m/s**2"] = 0.25


def prices(noise: Measured | RollingCar.Output, plausible: Readings) -> tuple[float, ...]:
    """Costs of leaving out each sensor, per sample with fault-free readings [nat].

    A cost is the mean log density of a normal innovation less the log density of the plausible range.

    Args:
        noise: standard deviations of the sensors, which make up most of the innovations
        plausible: widths of the ranges in which failed sensors may read

    Returns:
        costs in the order of `SENSORS`; 0 for sensors that the vehicle does not have
    """
    pairs = ((width, getattr(noise, name, None)) for name, width in zip(SENSORS, plausible, strict=True))
    return tuple(0.0 if known is None else log(width / (known * sqrt(2.0 * pi * e))) for width, known in pairs)


USUAL_RATE, USUAL_ANGLE, USUAL_ACCELERATION = 1.5, 1.5, 3.0
"""Usual rate [rad/s] and angle [rad] of the column, and lateral acceleration [m/s**2], at which the errors of
parameters are evaluated."""


def widened(vehicle: Vehicle) -> tuple[Measured, ModelError]:
    """Noises of sensors and model for a vehicle, widened by the standard deviations of its parameters.

    Args:
        vehicle: vehicle; a calibrated one widens hardly anything
    """

    def spread(name: str, relative: bool = False) -> float:
        deviation = held_deviation(vehicle, name) if name in vehicle else 0.0
        return deviation / abs(vehicle[name]) if relative and deviation else deviation

    error, square = ModelError(), vehicle["rack_ratio"] ** 2
    axles = ("front_cornering_stiffness", "rear_cornering_stiffness")
    share = hypot(spread("mass", True), *(spread(name, True) for name in axles))
    steering = hypot(
        spread("nominal_friction"),
        square * spread("rack_damping") * USUAL_RATE,
        square * spread("rack_stiffness") * USUAL_ANGLE,
    )
    scale = spread("wheel_speed_scale") * USUAL_ACCELERATION
    # Offsets of wheels, yaw rate and angle are states of the filter: their spread belongs to the model error instead.
    offsets = [
        *((spread(f"{name}_offset"),) if name not in OF_CARS else () for name in OF_AUTOMATED),
        *((spread(f"{name}_offset"), scale) for name in ACCELERATIONS),
    ]
    return (
        Measured(*(hypot(usual, *more) for usual, more in zip(SENSOR_NOISE, offsets, strict=True))),
        replace(
            error,
            acceleration=hypot(error.acceleration, scale),
            steering_torque=hypot(error.steering_torque, steering),
            force_share=hypot(error.force_share, share),
            tie_rod_share=hypot(error.tie_rod_share, share, spread("pneumatic_trail", True)),
            yaw_rate_offset=hypot(error.yaw_rate_offset, spread("yaw_rate_offset")),
            angle_offset=hypot(error.angle_offset, spread("steering_wheel_angle_offset")),
            wheel_speed_difference=hypot(error.wheel_speed_difference, spread("wheel_speed_difference")),
        ),
    )
