"""Signals of the motor angle monitor, the choice of the voltages for its observer, and what it assumes of both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
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


@dataclass(frozen=True)
class MotorAngleTuning:
    """Assumptions of the observer on its measurements, the motor and the inverter.

    Args:
        current_noise: standard deviation of a measured current; shunts and converters of such a drive
        voltage_noise: standard deviation of the mean voltage over a sample, with unmodelled effects
        sensor_noise: standard deviation of one reading of the angle sensor, used for increments only
        speed_wander: standard deviation of the unmodelled change of speed per sample
        load_wander: random walk of the load torque per sample; it may reverse within some 10 ms
        surprising: NIS above which the load has stepped; noise of two currents exceeds it once in 22 000 samples,
            with increments once in 6 000
        stepped_speed, stepped_load: standard deviations of both after a step: a load at its limit within one sample
        most_surprises, step_memory: number of surprises within that time up to which they are steps; more show a wrong
            model
        resistance_wander: random walk of its logarithm; a winding heats over seconds
        flux_wander: random walk of the logarithm of the flux; magnets warm over minutes
        loss_wander: random walk of the inverter's voltage loss; its semiconductors warm over seconds
        knee_wander: random walk of the logarithm of its knee
        standing_wander: random walk of the angle at standstill, the possible error of the sensor's increments
        first_angle, first_speed, first_load: initial standard deviations
        first_resistance, first_flux: initial standard deviations of their logarithms; temperatures from -40 to 120
            degrees
        first_loss: initial standard deviation of the inverter's voltage loss; the accuracy of its data sheet
        first_knee: initial standard deviation of the logarithm of its knee, which no data sheet gives; 0 takes it as
            known
        learnt_knee: standard deviation of that logarithm below which a surprise is attributed to the load
        least_current: current below which the resistance is not estimated, since noise alone would make it drift
        standing_speed: speed below which the back-EMF does not determine the angle
        standing_time: time for which the speed must be below
        slow_speed: speed below which increments of the sensor serve as speed measurements
        increment_time: time over which they are summed: their noise does not add up, and the motor hardly accelerates
        lag: time constant of the speed that selects the mode
        widest: bound of the logarithms of resistance and flux
        widest_knee: bound of that of the knee; from a fifth to five times its value
    """

    current_noise: Annotated[float, "A", POSITIVE] = 0.2
    voltage_noise: Annotated[float, "V", POSITIVE] = 0.05
    sensor_noise: Annotated[float, "rad", POSITIVE] = 5e-4
    speed_wander: Annotated[float, "rad/s", POSITIVE] = 0.1
    load_wander: Annotated[float, "N*m", POSITIVE] = 0.02
    surprising: Annotated[float, "", POSITIVE] = 20.0
    stepped_speed: Annotated[float, "rad/s", POSITIVE] = 5.0
    stepped_load: Annotated[float, "N*m", POSITIVE] = 1.0
    most_surprises: Annotated[float, "", POSITIVE] = 12.0
    step_memory: Annotated[float, "s", POSITIVE] = 0.05
    resistance_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.01
    flux_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 2e-4
    loss_wander: Annotated[float, "V/s**0.5", NOT_NEGATIVE] = 0.01
    knee_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.0
    standing_wander: Annotated[float, "rad/s**0.5", POSITIVE] = 0.02
    first_angle: Annotated[float, "rad", POSITIVE] = 0.07
    first_speed: Annotated[float, "rad/s", POSITIVE] = 20.0
    first_load: Annotated[float, "N*m", POSITIVE] = 0.3
    first_resistance: Annotated[float, "", POSITIVE] = 0.2
    first_flux: Annotated[float, "", POSITIVE] = 0.05
    first_loss: Annotated[float, "V", POSITIVE] = 0.3
    first_knee: Annotated[float, "", NOT_NEGATIVE] = 0.5
    learnt_knee: Annotated[float, "", POSITIVE] = 0.1
    least_current: Annotated[float, "A", POSITIVE] = 3.0
    standing_speed: Annotated[float, "rad/s", POSITIVE] = 1.0
    standing_time: Annotated[float, "s", POSITIVE] = 0.02
    slow_speed: Annotated[float, "rad/s", POSITIVE] = 8.0
    increment_time: Annotated[float, "s", POSITIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 0.005
    widest: Annotated[float, "", POSITIVE] = 0.7
    widest_knee: Annotated[float, "", POSITIVE] = 1.6

    def __post_init__(self) -> None:
        check_ranges(self)
