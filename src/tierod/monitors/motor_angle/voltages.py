"""Which voltages the motor angle's observer is fed with: measured, as the inverter is told, or from its duty cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

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
"""What each of them needs with every sample; duty cycles a supply besides, however seldom."""

VARIANTS = {MEASURED: "stator-frame", COMMANDED: "commanded-voltage", DUTY_CYCLES: "duty-cycles"}
"""Names of the monitor's variants."""

TOLD = {
    COMMANDED: "those that the inverter was told to make, less what it was found to take",
    DUTY_CYCLES: "duty cycles times the supply, less what the inverter was found to take",
}
"""In words, where they are not measured."""


class VoltageSignals(NamedTuple):
    """Everything that may tell the voltage, means over the sample that ends; NaN where a sample brings none."""

    motor_voltage_alpha: Annotated[float, "V"]
    motor_voltage_beta: Annotated[float, "V"]
    motor_target_voltage_alpha: Annotated[float, "V"]
    motor_target_voltage_beta: Annotated[float, "V"]
    motor_duty_cycle_a: Annotated[float, ""]
    motor_duty_cycle_b: Annotated[float, ""]
    motor_duty_cycle_c: Annotated[float, ""]
    supply_voltage: Annotated[float, "V"]


@dataclass(frozen=True)
class MotorVoltages:
    """The voltage in the stator's axes; a supply that comes seldom is held.

    Args:
        source: "measured", "commanded", or "duty cycles"
    """

    source: Literal["measured", "commanded", "duty cycles"] = "measured"

    Sample = VoltageSignals

    class State(NamedTuple):
        """Last supply, and whether there is one."""

        supply_voltage: Any
        told: Any

    class Output(NamedTuple):
        """In the stator's axes."""

        alpha: Annotated[float, "V"]
        beta: Annotated[float, "V"]

    def __post_init__(self) -> None:
        if self.source not in SIGNALS:
            raise ParameterError(f"the voltages are '{self.source}'; expected one of {', '.join(SIGNALS)}")

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        if self.source == MEASURED:
            return state, self.Output(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        if self.source == COMMANDED:
            return state, self.Output(sample.motor_target_voltage_alpha, sample.motor_target_voltage_beta)
        fresh = present(sample.supply_voltage)
        supply = where(fresh, sample.supply_voltage, state.supply_voltage)
        told = where(fresh, 1.0, state.told)
        # Before the first supply the missing one itself makes the voltage missing.
        known = where(told, supply, sample.supply_voltage)
        duty = PhaseValues(sample.motor_duty_cycle_a, sample.motor_duty_cycle_b, sample.motor_duty_cycle_c)
        made = commanded_voltage(duty, known)
        return self.State(supply, told), self.Output(*made)
