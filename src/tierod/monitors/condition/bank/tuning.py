"""Noises, ranges and limits of the filter behind every hypothesis."""

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
"""Standard deviation of one reading of every sensor, in its unit."""
PLAUSIBLE = Readings(*(each.plausible for each in SENSOR_TABLE))
"""Width of the range in which a failed sensor may read anything: the density of its readings is one over it."""
TORQUE_JUMP = 0.45
"""Share of a jump of the steering torque that is not known, since it happens between two samples: uniform over it."""


@dataclass(frozen=True)
class ModelError:
    """Standard deviation of the model's error; the share of the force adapts every threshold.

    Args:
        acceleration: along the road, white, per sample
        lateral_acceleration: white, per sample
        yaw_acceleration: white, per sample
        slip: of the tyres' deflection, white, per sample
        steering_torque: of both motors, white, per sample
        friction_share: of the column's friction, white, per sample
        force, force_share: of an axle: lasting error at small force, and its growth with the force
        tie_rod, tie_rod_share: likewise, of the tie rod's force
        standing: added to the tie rod's error at standstill, where the tyres twist on the spot
        loss: of the torque of a suspected actuator, as a share
        yaw_rate_offset, angle_offset, wheel_speed_difference: deviations from a calibration
        wheel_speed_scale, drive_excess: likewise, as shares: load and tyres change after a calibration
        wheel_speed_scale_alone: likewise, where the yaw rate or a wheel is left out: nothing would show it but the
            acceleration across, which the body's roll bends by some percent
        drive_excess_alone: likewise, where a drive is suspected: half a torque lost on one side is a quarter on both
        road: acceleration by grade or bank
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
    """Costs of leaving out each sensor, per sample while its readings are as expected [nat].

    The mean density of a reading about its expectation, in logarithms, over that of anything plausible.

    Args:
        noise: of the sensors, which is most of what expectations miss
        plausible: ranges of failed sensors

    Returns:
        in the order of `SENSORS`; 0 of those that the vehicle does not have
    """
    pairs = ((width, getattr(noise, name, None)) for name, width in zip(SENSORS, plausible, strict=True))
    return tuple(0.0 if known is None else log(width / (known * sqrt(2.0 * pi * e))) for width, known in pairs)


USUAL_RATE, USUAL_ANGLE, USUAL_ACCELERATION = 1.5, 1.5, 3.0
"""Of the column [rad/s], [rad], and across the vehicle [m/s**2]: what wrong parameters are multiplied with."""


def widened(vehicle: Vehicle) -> tuple[Measured, ModelError]:
    """Noises that hold for a vehicle: the standard deviations of its parameters come on top of the usual ones.

    Args:
        vehicle: calibrated, which adds next to nothing, or not
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
    # What the filter learns itself, offsets of wheels, yaw rate and angle, counts as an error of the model.
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
