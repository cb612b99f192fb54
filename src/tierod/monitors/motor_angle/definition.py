"""The monitor of the motor's angle sensor and its variants."""

from __future__ import annotations

from functools import partial
from typing import TypeVar

from tierod.core.errors import ParameterError
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Variant
from tierod.monitors.motor_angle.causes import LEAST_KNOWN
from tierod.monitors.motor_angle.decisions import DECISIONS
from tierod.monitors.motor_angle.monitor import MotorAngleMonitor
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Superposition, VariableGain
from tierod.monitors.motor_angle.session import MotorAngleSession
from tierod.monitors.motor_angle.signals import COMMANDED, DUTY_CYCLES, MEASURED, SIGNALS, VARIANTS, MotorVoltages
from tierod.monitors.motor_angle.which_angle import WhichAngle
from tierod.vehicles import Vehicle

PAPER = "Reinelt, Lundquist, Johansson, On-line sensor monitoring in an active front steering system, SAE 2005-01-1271"


Part = TypeVar("Part")


def _open(voltages: str, vehicle: Vehicle, rate: float, baseline: Baseline | None) -> MotorAngleSession:
    plausibility, gear = None, _if_given(vehicle, Superposition)
    if gear is not None:
        gain, which = _if_given(vehicle, VariableGain), WhichAngle(1.0 / rate)
        plausibility = AnglePlausibility(gear, 1.0 / rate, gain=gain, which=which)
    source = MotorVoltages(voltages)  # type: ignore[arg-type]
    return MotorAngleSession(MotorAngleMonitor.of_vehicle(vehicle, 1.0 / rate, plausibility, source), vehicle, rate)


def _if_given(vehicle: Vehicle, kind: type[Part]) -> Part | None:
    """Parameters of this kind; None where the vehicle file leaves them out."""
    try:
        return vehicle.parameters_for(kind)
    except ParameterError:
        return None


def _required(voltages: str) -> tuple[str, ...]:
    return ("motor_current_alpha", "motor_current_beta", *SIGNALS[voltages], "motor_angle_mechanical")


def _variant(voltages: str, summary: str) -> Variant:
    source = f"beyond {PAPER}; docs/explanation/motor-angle.md"
    opener = partial(_open, voltages)
    return Variant(VARIANTS[voltages], summary, source, opener, DECISIONS, required=_required(voltages))


MOTOR_ANGLE = Monitor(
    name="motor-angle",
    title="Sensor of the motor's angle",
    summary="Compares a motor's angle sensor with the angle that its currents and voltages give, and names its faults.",
    source=PAPER,
    drive=f"Steering that turns the motor faster than about 10 rad/s, for at least {LEAST_KNOWN:g} s in all.",
    required=_required(MEASURED),
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
        "vehicle_speed",
        *SIGNALS[COMMANDED],
        *SIGNALS[DUTY_CYCLES],
    ),
    rate=10_000.0,
    minimum_rate=500.0,
    # A slow channel is valid at its readings only: a held angle would look like a stuck sensor.
    maximum_age=0.6e-4,
    variants={
        each.name: each
        for each in (
            _variant(
                MEASURED,
                "Kalman filter in stator coordinates without the sensor, cumulative sums, further tests.",
            ),
            _variant(
                COMMANDED,
                "The same with the commanded voltages; the voltage loss of the inverter is estimated too.",
            ),
            _variant(
                DUTY_CYCLES,
                "The same with duty cycles and supply voltage; the voltage loss of the inverter is estimated too.",
            ),
        )
    },
    default=VARIANTS[MEASURED],
    # A stuck angle sensor is a fault that this monitor detects itself.
    subjects=("motor_angle_mechanical", "resolver_sine", "resolver_cosine"),
)
