"""What a vehicle file tells of noises and of what wanders: the tuning of the combined estimator for this car."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated

from tierod.monitors.sideslip.car_signals import BY_WIRE
from tierod.monitors.sideslip.combined_tuning import CombinedTuning, Wandering
from tierod.vehicles.vehicle import Vehicle

USUAL = CombinedTuning()

USUAL_TIME = 60.0
"""Over which a wander changes where neither the file nor the usual tuning says [s]."""

WIND_ARM = 0.5
"""Distance of the wind's force from the centre of gravity [m], a typical one of passenger cars."""

THROUGH_A_COLUMN = Wandering(0.001, 3.0)
"""Error of a road wheels' angle that comes from the steering wheel [rad]: the torsion bar twists, the steering yields,
the ratio is not constant. Believed to the letter, an angle that is off by 0.04 degrees halves the stiffness that is
found in bends of a country road. Chosen on three virtual drives; on three others the error is 0.2 to 0.4 of that."""

LATERAL_ACCELERATION = Wandering(0.1, 600.0)
"""Offset and misalignment (half a degree) of a production car's accelerometer [m/s2], which change with temperature."""

YAW_RATE = Wandering(0.002, 600.0)
"""Offset of a production car's yaw rate [rad/s] after calibration at standstill, a tenth of a degree per second. Either
of the two alone makes the estimate worse: what it leaves unexplained is then laid upon the other."""


@dataclass(frozen=True)
class VehicleTuning:
    """Noises and wanders as a vehicle file names them; where it does not, those of `CombinedTuning`.

    Args:
        yaw_rate_noise, lateral_acceleration_noise: of one reading, with the vibration that reaches the sensor
        lateral_speed_drift, yaw_rate_drift: growth of what the tyre model lacks
        stiffness_wander, stiffness_wander_time: of the cornering stiffness of both axles, relative
        friction_wander: of the tyres' friction, relative
        bank_wander, bank_wander_time: of the road
        wind_wander: lateral force; its moment wanders by `WIND_ARM` times as much
        lateral_acceleration_wander, lateral_acceleration_wander_time: bias of the sensor. Where the file names none, it
            is `LATERAL_ACCELERATION` and the yaw rate has `YAW_RATE`; neither in a car steered by wire, whose sensors
            are those of a test car
        road_wheel_angle_wander, road_wheel_angle_wander_time: error of the angle; usually `THROUGH_A_COLUMN`, and none
            in a car steered by wire

    A wander of zero is none: its unknown is left out.
    """

    yaw_rate_noise: Annotated[float, "rad/s"] = USUAL.noises.yaw_rate_reading
    lateral_acceleration_noise: Annotated[float, "m/s**2"] = USUAL.noises.lateral_acceleration_reading
    lateral_speed_drift: Annotated[float, "m/s**1.5"] = USUAL.noises.lateral_speed
    yaw_rate_drift: Annotated[float, "rad/s**1.5"] = USUAL.noises.yaw_rate
    stiffness_wander: Annotated[float, ""] | None = None
    stiffness_wander_time: Annotated[float, "s"] | None = None
    friction_wander: Annotated[float, ""] | None = None
    bank_wander: Annotated[float, "rad"] | None = None
    bank_wander_time: Annotated[float, "s"] | None = None
    wind_wander: Annotated[float, "N"] | None = None
    lateral_acceleration_wander: Annotated[float, "m/s**2"] | None = None
    lateral_acceleration_wander_time: Annotated[float, "s"] | None = None
    road_wheel_angle_wander: Annotated[float, "rad"] | None = None
    road_wheel_angle_wander_time: Annotated[float, "s"] | None = None


def tuning_of(vehicle: Vehicle, usual: CombinedTuning = USUAL) -> CombinedTuning:
    """The tuning of the combined estimator for a vehicle.

    Args:
        vehicle: whose file may name parameters of `VehicleTuning`
        usual: the tuning where it does not
    """
    given = vehicle.parameters_for(VehicleTuning)
    stiffness = given.stiffness_wander, given.stiffness_wander_time
    angle, acceleration, yaw = usual.road_wheel_angle_offset, usual.lateral_acceleration_bias, usual.yaw_rate_bias
    if BY_WIRE not in vehicle:
        angle = angle or THROUGH_A_COLUMN
        if given.lateral_acceleration_wander is None:
            acceleration, yaw = acceleration or LATERAL_ACCELERATION, yaw or YAW_RATE
    return dataclasses.replace(
        usual,
        log_front_stiffness=_wandering(usual.log_front_stiffness, *stiffness),
        log_rear_stiffness=_wandering(usual.log_rear_stiffness, *stiffness),
        log_friction=_wandering(usual.log_friction, given.friction_wander, None),
        bank_angle=_wandering(usual.bank_angle, given.bank_wander, given.bank_wander_time),
        side_force=_wandering(usual.side_force, given.wind_wander, None),
        side_moment=_wandering(
            usual.side_moment, None if given.wind_wander is None else WIND_ARM * given.wind_wander, None
        ),
        lateral_acceleration_bias=_wandering(
            acceleration, given.lateral_acceleration_wander, given.lateral_acceleration_wander_time
        ),
        yaw_rate_bias=yaw,
        road_wheel_angle_offset=_wandering(angle, given.road_wheel_angle_wander, given.road_wheel_angle_wander_time),
        noises=dataclasses.replace(
            usual.noises,
            lateral_speed=given.lateral_speed_drift,
            yaw_rate=given.yaw_rate_drift,
            yaw_rate_reading=given.yaw_rate_noise,
            lateral_acceleration_reading=given.lateral_acceleration_noise,
        ),
    )


def _wandering(usual: Wandering | None, deviation: float | None, time: float | None) -> Wandering | None:
    """The wander with what is given of it; None where it is given as zero, or is neither usual nor given."""
    if deviation == 0.0 or (usual is None and deviation is None):
        return None
    start = usual or Wandering(1.0, USUAL_TIME)
    return dataclasses.replace(
        start, deviation=start.deviation if deviation is None else deviation, time=start.time if time is None else time
    )
