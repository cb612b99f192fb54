"""Signals of the motor angle monitor, and the choice of the voltages for its observer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import present, where
from tierod.physics.clarke_park import PhaseValues
from tierod.physics.inverter import commanded_voltage

MEASURED, COMMANDED, DUTY_CYCLES = "measured", "commanded", "duty cycles"

SIGNALS = {
    MEASURED: ("motor_voltage_alpha", "motor_voltage_beta"),
    COMMANDED: ("motor_target_voltage_alpha", "motor_target_voltage_beta"),
    DUTY_CYCLES: ("motor_duty_cycle_a", "motor_duty_cycle_b", "motor_duty_cycle_c"),
}
"""Signals that each voltage source needs in every sample; duty cycles also need a supply voltage, however seldom."""

VARIANTS = {MEASURED: "stator-frame", COMMANDED: "commanded-voltage", DUTY_CYCLES: "duty-cycles"}
"""Names of the monitor's variants."""

IN_WORDS = {
    COMMANDED: "the commanded ones, less the estimated voltage loss of the inverter",
    DUTY_CYCLES: "duty cycles times the supply, less the estimated voltage loss of the inverter",
}
"""Voltage sources other than measurement, in words."""


class MotorAngleSample(NamedTuple):
    """Currents, mean voltages over the sample that ends, and the angle; then all further signals, or NaN.

    Targets and duty cycles are those of the period that ends with the sample.
    """

    motor_current_alpha: Annotated[Scalar, "A"]
    motor_current_beta: Annotated[Scalar, "A"]
    motor_voltage_alpha: Annotated[Scalar, "V"]
    motor_voltage_beta: Annotated[Scalar, "V"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    target_motor_angle_mechanical: Annotated[Scalar, "rad"]
    motor_current_a: Annotated[Scalar, "A"]
    motor_current_b: Annotated[Scalar, "A"]
    motor_current_c: Annotated[Scalar, "A"]
    resolver_sine: Annotated[Scalar, "V"]
    resolver_cosine: Annotated[Scalar, "V"]
    supply_voltage: Annotated[Scalar, "V"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    pinion_angle: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]
    motor_target_voltage_alpha: Annotated[Scalar, "V"]
    motor_target_voltage_beta: Annotated[Scalar, "V"]
    motor_duty_cycle_a: Annotated[Scalar, ""]
    motor_duty_cycle_b: Annotated[Scalar, ""]
    motor_duty_cycle_c: Annotated[Scalar, ""]
    vehicle_speed: Annotated[Scalar, "m/s"]


@dataclass(frozen=True)
class MotorVoltages:
    """Voltage in stator coordinates, from the chosen source; a supply voltage at a low rate is held.

    Args:
        source: "measured", "commanded", or "duty cycles"
    """

    source: Literal["measured", "commanded", "duty cycles"] = "measured"

    Sample = MotorAngleSample

    class State(NamedTuple):
        """Last supply voltage, and whether there is one."""

        supply_voltage: Annotated[Scalar, "V"]
        known: Annotated[Scalar, ""]

    class Output(NamedTuple):
        """Voltage in stator coordinates."""

        alpha: Annotated[Scalar, "V"]
        beta: Annotated[Scalar, "V"]

    def __post_init__(self) -> None:
        if self.source not in SIGNALS:
            raise ParameterError(f"the voltages are '{self.source}'; expected one of {', '.join(SIGNALS)}")

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        """Process one sample."""
        if self.source == MEASURED:
            return state, self.Output(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        if self.source == COMMANDED:
            return state, self.Output(sample.motor_target_voltage_alpha, sample.motor_target_voltage_beta)
        fresh = present(sample.supply_voltage)
        supply = where(fresh, sample.supply_voltage, state.supply_voltage)
        known = where(fresh, 1.0, state.known)
        # Before the first supply reading the NaN itself makes the voltage missing.
        voltage = where(known, supply, sample.supply_voltage)
        duty = PhaseValues(sample.motor_duty_cycle_a, sample.motor_duty_cycle_b, sample.motor_duty_cycle_c)
        return self.State(supply, known), self.Output(*commanded_voltage(duty, voltage))
