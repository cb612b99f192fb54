"""The bare equations of the paper's methods, for counting operations: no initialisation, no gaps, no decisions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import arctan
from tierod.physics.clarke_park import Direction, RotorVector, StatorVector, direction, electrical_angle, park

STEP = 1e-4  # Sampling interval [s]
POLE_PAIRS = 4.0


class Seen(NamedTuple):
    """Voltages and currents in the stator frame, and the sensor angle of Park's transform (8, 9)."""

    voltage_alpha: Annotated[Scalar, "V"]
    voltage_beta: Annotated[Scalar, "V"]
    current_alpha: Annotated[Scalar, "A"]
    current_beta: Annotated[Scalar, "A"]
    motor_angle: Annotated[Scalar, "rad"]


class Found(NamedTuple):
    """Angle and speed, and the d-axis outputs of Park's transform, whose operations the paper counts."""

    motor_angle: Annotated[Scalar, "rad"]
    motor_speed: Annotated[Scalar, "rad/s"]
    direct_voltage: Annotated[Scalar, "V"]
    direct_current: Annotated[Scalar, "A"]


def _rotor(sample: Seen, rotor: Direction) -> tuple[RotorVector, RotorVector]:
    voltage = park(StatorVector(sample.voltage_alpha, sample.voltage_beta), rotor)
    return voltage, park(StatorVector(sample.current_alpha, sample.current_beta), rotor)


class FullState(NamedTuple):
    """States of the full observer: current, speed and angle, three integrators."""

    current: Annotated[Scalar, "A"]
    speed: Annotated[Scalar, "rad/s"]
    angle: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class BareLuenberger:
    """Full Luenberger observer of eqs (8), (9) and (23), by Euler's method."""

    # current_current, current_speed, speed_current, speed_speed: A of (20)
    current_current: Annotated[float, "1/s"] = -500.0
    current_speed: Annotated[float, "A/rad"] = -340.0
    speed_current: Annotated[float, "rad/A/s**2"] = 425.0
    speed_speed: Annotated[float, "1/s"] = -3.3
    current_voltage: Annotated[float, "A/V/s"] = 1e4  # B of (20)
    current_gain: Annotated[float, "1/s"] = 800.0  # current_gain, speed_gain: K of (23)
    speed_gain: Annotated[float, "rad/A/s**2"] = -400.0

    Sample = Seen

    def init(self) -> FullState:
        return FullState(0.0, 0.0, 0.0)

    def step(self, state: FullState, sample: Seen) -> tuple[FullState, Found]:
        voltage, current = _rotor(sample, direction(electrical_angle(sample.motor_angle, POLE_PAIRS)))
        off = current.q - state.current
        by_states = self.current_current * state.current + self.current_speed * state.speed
        rise = by_states + self.current_voltage * voltage.q + self.current_gain * off
        gain = self.speed_current * state.current + self.speed_speed * state.speed + self.speed_gain * off
        after = FullState(state.current + STEP * rise, state.speed + STEP * gain, state.angle + STEP * state.speed)
        return after, Found(after.angle, after.speed, voltage.d, current.d)


class ReducedState(NamedTuple):
    """States of the reduced observer: x_B and angle, two integrators."""

    inner: Annotated[Scalar, "rad/s"]
    angle: Annotated[Scalar, "rad"]


class Motor(NamedTuple):
    """Voltages, currents and angle, and the parameters of the motor as inputs of every step."""

    seen: Seen
    gain: Annotated[Scalar, "rad/A/s"]
    resistance: Annotated[Scalar, "ohm"]
    inductance: Annotated[Scalar, "H"]
    machine_constant: Annotated[Scalar, "V*s/rad"]
    torque_constant: Annotated[Scalar, "N*m/A"]
    inertia: Annotated[Scalar, "kg*m**2"]
    damping: Annotated[Scalar, "N*m*s/rad"]


@dataclass(frozen=True)
class BareReduced:
    """Reduced Luenberger observer of eqs (8), (9), (32) corrected and (33), by Euler's method.

    The coefficients are computed in every step, as the equations are written.
    """

    Sample = Motor

    def init(self) -> ReducedState:
        return ReducedState(0.0, 0.0)

    def step(self, state: ReducedState, sample: Motor) -> tuple[ReducedState, Found]:
        s = sample
        voltage, current = _rotor(s.seen, direction(electrical_angle(s.seen.motor_angle, POLE_PAIRS)))
        pole = -s.damping / s.inertia + s.gain * s.machine_constant / s.inductance
        by_current = pole * s.gain + s.torque_constant / s.inertia + s.gain * s.resistance / s.inductance
        slope = pole * state.inner + by_current * current.q - s.gain / s.inductance * voltage.q
        inner = state.inner + STEP * slope
        speed = inner + s.gain * current.q
        after = ReducedState(inner, state.angle + STEP * speed)
        return after, Found(after.angle, speed, voltage.d, current.d)


class FilteredState(NamedTuple):
    """Low-pass filtered currents: two integrators, whose rates are the derivatives."""

    alpha: Annotated[Scalar, "A"]
    beta: Annotated[Scalar, "A"]


class FeedforwardFound(NamedTuple):
    """Electrical angle of the feedforward."""

    electrical_angle: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class BareFeedforward:
    """Eq (46) with minus L dI/dt, its quotient as printed, and derivatives of the currents by a low-pass filter."""

    resistance: Annotated[float, "ohm"] = 0.05  # resistance, inductance: phase resistance and inductance
    inductance: Annotated[float, "H"] = 1e-4
    bandwidth: Annotated[float, "rad/s"] = 1885.0  # bandwidth of the low-pass filter

    Sample = Seen

    def init(self) -> FilteredState:
        return FilteredState(0.0, 0.0)

    def step(self, state: FilteredState, sample: Seen) -> tuple[FilteredState, FeedforwardFound]:
        share, slope = self.bandwidth * STEP, self.inductance * self.bandwidth
        away = (sample.current_alpha - state.alpha, sample.current_beta - state.beta)
        alpha = sample.voltage_alpha - self.resistance * sample.current_alpha - slope * away[0]
        beta = sample.voltage_beta - self.resistance * sample.current_beta - slope * away[1]
        after = FilteredState(state.alpha + share * away[0], state.beta + share * away[1])
        return after, FeedforwardFound(arctan(-alpha / beta))
