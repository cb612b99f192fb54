"""The monitor of the motor's angle sensor, as users see it."""

from __future__ import annotations

from tierod.errors import ParameterError
from tierod.monitors.motor_angle.detector import MotorAngleMonitor
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Superposition
from tierod.monitors.motor_angle.session import MotorAngleSession
from tierod.monitors.own_level import OwnLevel
from tierod.monitors.session import Monitor, Variant
from tierod.vehicles import Vehicle

PAPER = "Reinelt, Lundquist, Johansson, On-line sensor monitoring in an active front steering system, SAE 2005-01-1271"


def _open(vehicle: Vehicle, rate: float, own_level: OwnLevel | None) -> MotorAngleSession:
    try:
        gear = vehicle.parameters_for(Superposition)
    except ParameterError:
        gear = None
    plausibility = AnglePlausibility(gear, 1.0 / rate) if gear is not None else None
    return MotorAngleSession(MotorAngleMonitor.of_vehicle(vehicle, 1.0 / rate, plausibility), vehicle, rate)


MOTOR_ANGLE = Monitor(
    name="motor-angle",
    title="Sensor of the motor's angle",
    summary="Compares a motor's angle sensor with the angle that its currents and voltages tell, and names its faults.",
    source=PAPER,
    required=(
        "motor_current_alpha",
        "motor_current_beta",
        "motor_voltage_alpha",
        "motor_voltage_beta",
        "motor_angle_mechanical",
    ),
    optional=(
        "target_motor_angle_mechanical",
        "motor_current_a",
        "motor_current_b",
        "motor_current_c",
        "resolver_sine",
        "resolver_cosine",
        "supply_voltage",
        "steering_wheel_angle",
        "pinion_angle",
        "driver_torque",
    ),
    rate=10_000.0,
    minimum_rate=500.0,
    # Slow channels count where they bring a reading, not in between: a held angle would be one that stands still.
    maximum_age=0.6e-4,
    variants={
        "stator-frame": Variant(
            "stator-frame",
            "Kalman filter in the stator's axes without the sensor, cumulative sums, second tests, electrical checks.",
            f"beyond {PAPER}; docs/motor-angle.md",
            _open,
        )
    },
    default="stator-frame",
)
