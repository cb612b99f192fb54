"""Signals of the condition monitor: one table of sensors, one of actuators, and the types made from them.

A further sensor is one more row of `SENSOR_TABLE`, an output of the vehicle's model, and a trouble code; what
substitutes and checks of recordings can make of it stands in their own tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple, TypeAlias

from tierod.core.block import Scalar, named_tuple
from tierod.core.signals import SIGNALS
from tierod.core.statement import Statement
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.rolling_car import RollingCar

CarParameters: TypeAlias = AutomatedVehicle.Parameters | RollingCar.Parameters
"""Of a vehicle whose torques are known, or of one that is judged by its motion alone."""


class Sensor(NamedTuple):
    """A sensor that is judged; every number in the unit of its signal unless another is named.

    Args:
        name: of its signal
        noise: standard deviation of one reading; data sheets of production sensors, rounding included
        plausible: width of the range in which a failed sensor may read anything
        growth: by which a held value may be off after a second, from usual rates of change [unit per s]
        error_on_cars: root-mean-square error of the filter that leaves it out, the larger of two real cars; of sensors
            that cars do not have, which are never supplied, what they may change in a second
        lasting: errors of its prediction stay alike for so long [s]; by the variance of their means over two or ten
            seconds, on fault-free drives of three virtual demonstrators: 0.2 to 0.7 s for the yaw rate, 0.6 to 2.0 s
            for the angle, 0.05 s at most for all others. In a hard bend they last longer
        jumps: whether its signal jumps, as the torque does with what is asked of the motors
    """

    name: str
    noise: float
    plausible: float
    growth: float
    error_on_cars: float
    lasting: float = 0.1
    jumps: bool = False


SENSOR_TABLE = (
    # A wheel's noise holds the unevenness of the road; an angle's the rounding to 0.1 degrees, and where in the sample
    # it is read; torque and force come from strain gauges.
    Sensor("wheel_speed_rear_left", 0.022, 30.0, 1.0, 0.051),
    Sensor("wheel_speed_rear_right", 0.022, 30.0, 1.0, 0.065),
    Sensor("yaw_rate", 0.0032, 4.0, 0.3, 0.015, lasting=1.0),
    Sensor("steering_wheel_angle", 6e-4, 16.0, 1.5, 0.21, lasting=2.0),
    Sensor("steering_shaft_torque", 0.11, 60.0, 3.0, 3.0, jumps=True),
    Sensor("tie_rod_force", 20.5, 4000.0, 200.0, 200.0),
    # Of production cars alone: the model of the automated vehicle does not predict its front wheels.
    Sensor("wheel_speed_front_left", 0.022, 30.0, 1.0, 0.041),
    Sensor("wheel_speed_front_right", 0.022, 30.0, 1.0, 0.060),
)
"""The sensors that are judged, in the order of all outputs."""

SENSORS = tuple(each.name for each in SENSOR_TABLE)
"""Their names."""

OF_AUTOMATED = tuple(name for name in SENSORS if name in AutomatedVehicle.Output._fields)
OF_CARS = tuple(name for name in RollingCar.Output._fields if name in SENSORS)
"""Those of an automated vehicle whose torques are known, and those of a car that is judged by its motion."""

WHEELS = SENSORS[:2]
FRONT_WHEELS = tuple(name for name in SENSORS if name.startswith("wheel_speed_front"))
ALL_WHEELS = WHEELS + FRONT_WHEELS
"""The sensors of the speed: of the rear axle, of the front axle, of both."""

SHAFT_TORQUE = "steering_shaft_torque"
"""The sensor that observes what both steering motors give together."""

ACCELERATIONS = ("longitudinal_acceleration", "lateral_acceleration")
"""Sensors that help and are replaced by nothing; the other sensors show whether they are right."""

ACCELERATION_NOISE = 0.12
"""Standard deviation of one reading of either [m/s**2]."""


class Actuator(NamedTuple):
    """An actuator that is judged.

    Args:
        name: of the actuator
        target: signal of the torque that is asked of it
        needs: sensor without which no drive shows whether it gives what is asked; "" where there is none
    """

    name: str
    target: str
    needs: str = ""


ACTUATOR_TABLE = (
    Actuator("steering_motor_1", "steering_motor_1_target_torque", SHAFT_TORQUE),
    Actuator("steering_motor_2", "steering_motor_2_target_torque", SHAFT_TORQUE),
    Actuator("drive_left", "target_drive_torque_left"),
    Actuator("drive_right", "target_drive_torque_right"),
)
"""The actuators that are judged, in the order of all outputs."""

ACTUATORS = tuple(each.name for each in ACTUATOR_TABLE)
"""Their names."""

TARGETS = tuple(each.target for each in ACTUATOR_TABLE)
"""What is asked of them, in their order."""

MOTORS, DRIVES = ACTUATORS[:2], ACTUATORS[2:]
"""Actuators that turn the column together, and that push the vehicle together. Where what feeds or enables them fails,
both lose the same share."""

STEERING_TORQUES = ("steering_shaft_torque", "tie_rod_force", *MOTORS)
"""What stands in the balance of torques about the steering axis."""

ELEMENTS = SENSORS + ACTUATORS
"""Everything that is judged, in the order of all outputs."""

NEEDED = {each.name: each.needs for each in ACTUATOR_TABLE if each.needs}
"""Sensor without which an actuator is not observable."""


def _of_signals(name: str, signals: tuple[str, ...]) -> Any:
    return named_tuple(name, [(each, Annotated[float, SIGNALS[each].unit]) for each in signals])


Readings: Any = _of_signals("Readings", SENSORS)
"""One number per sensor, in its unit."""

Measured: Any = _of_signals("Measured", (*OF_AUTOMATED, *ACCELERATIONS))
"""One number per sensor of an automated vehicle, accelerations included, in its unit."""

Elements: Any = named_tuple("Elements", [(name, Annotated[float, ""]) for name in ELEMENTS])
"""One number per sensor and actuator; mostly whether (1) or not (0)."""

Statements: Any = named_tuple("Statements", [(name, Statement) for name in ELEMENTS])
"""What is stated about every sensor and actuator."""

ConditionSample: Any = _of_signals(
    "ConditionSample",
    (
        *(*OF_AUTOMATED, *ACCELERATIONS, *TARGETS, "target_steering_wheel_angle", "target_vehicle_speed"),
        *(name for name in SENSORS if name not in OF_AUTOMATED),
    ),
)
"""One sample of the vehicle; NaN where a signal is missing.

Wheel speeds are circumferential, the angle is that of the column, the shaft's torque lies below both steering motors,
the tie-rod force is the sum of both sides, positive where it opposes a turn to the left; accelerations are specific
forces at the sensor. Targets: torques asked of the motors, at their shafts, and of the drives, at the wheels; the last
two of them are what the control wants. Then come the sensors that only production cars have.
"""

PLACES = [ConditionSample._fields.index(name) for name in SENSORS]
"""Where the sensors stand in the sample."""


def readings_of(sample: ConditionSample) -> Readings:
    """The readings of all sensors.

    Args:
        sample: of the vehicle
    """
    return Readings(*(getattr(sample, name) for name in SENSORS))


def readings_by(values: Mapping[str, Scalar], other: Scalar = 0.0) -> Readings:
    """One number per sensor.

    Args:
        values: by name
        other: of sensors that a vehicle does not have
    """
    return Readings(*(values.get(name, other) for name in SENSORS))
