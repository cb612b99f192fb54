"""Field-oriented control of the current in a permanent-magnet motor, by its control unit's model of the motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import exp, limit
from tierod.physics.clarke_park import Direction, RotorVector, StatorVector, inverse_park, park, turned
from tierod.physics.inverter import limited_voltage
from tierod.physics.pm_motor import torque_constant
from tierod.proving_ground.motor.set_points import SetPoints


class ControlMemory(NamedTuple):
    """State of the control unit.

    Args:
        integral: of the current error, as voltage [V]
        angle: mechanical, as sensed at the sample before [rad]
        speed: mechanical, from the sensed angle [rad/s]
        command: voltage that the inverter makes in the period to come [V]
    """

    integral: RotorVector
    angle: Scalar
    speed: Scalar
    command: StatorVector


@dataclass(frozen=True)
class CurrentControl:
    """Proportional-integral control in the rotor's axes with feed-forward of the voltages that the turning induces.

    The command of a sample is made in the next period, as in every digital drive; it is turned ahead by the angle that
    the rotor turns until then. The motor's parameters that the unit assumes are numbers of its own.

    Args:
        resistance, inductance_d, inductance_q, flux: assumed
        lag: time constant of the closed current loop; 1/3 ms leaves room for one and a half periods of delay at 10 kHz
        current_limit: longest current vector
        speed_time: of the low-pass on the sensed speed; 0 is none
        weakening: share of the longest voltage up to which `SetPoints` choose the current along the flux; None asks
            for none along it
    """

    resistance: Annotated[float, "ohm", POSITIVE] = 0.05
    inductance_d: Annotated[float, "H", POSITIVE] = 1e-4
    inductance_q: Annotated[float, "H", POSITIVE] = 1e-4
    flux: Annotated[float, "V*s", POSITIVE] = 0.0085
    lag: Annotated[float, "s", POSITIVE] = 1.0 / 3000.0
    current_limit: Annotated[float, "A", POSITIVE] = 60.0
    speed_time: Annotated[float, "s", NOT_NEGATIVE] = 5e-4
    weakening: Annotated[float, "", SHARE] | None = None

    def remembered(self) -> ControlMemory:
        """At rest, no voltage."""
        return ControlMemory(RotorVector(0.0, 0.0), 0.0, 0.0, StatorVector(0.0, 0.0))

    def wanted_current(self, torque: Scalar, pole_pairs: int) -> Scalar:
        """Current across the flux [A] for a torque at the shaft [N*m], within the limit; none along the flux."""
        return limit(torque / torque_constant(pole_pairs, self.flux), -self.current_limit, self.current_limit)

    def step(
        self,
        memory: ControlMemory,
        wanted: Scalar,
        current: StatorVector,
        angle: Scalar,
        rotor: Direction,
        longest: Scalar,
        period: Scalar,
        pole_pairs: int,
    ) -> ControlMemory:
        """One sample; the new command is in the memory.

        Args:
            memory: of the sample before
            wanted: current across the flux [A]
            current: measured [A]
            angle: sensed, mechanical [rad]
            rotor: direction of the sensed angle, electrical
            longest: voltage that can be made [V]
            period: between two samples [s]
            pole_pairs: of the motor
        """
        speed = self._speed(memory, angle, period)
        electrical_speed = pole_pairs * speed
        own = park(current, rotor)
        target = RotorVector(0.0, wanted)
        if self.weakening is not None:
            points = SetPoints(self.inductance_d, self.inductance_q, self.flux, self.current_limit)
            target = points.of(wanted, electrical_speed, self.weakening * longest)
        error = RotorVector(target.d - own.d, target.q - own.q)
        gain_d, gain_q = self.inductance_d / self.lag, self.inductance_q / self.lag
        asked = RotorVector(
            memory.integral.d + gain_d * error.d - electrical_speed * self.inductance_q * own.q,
            memory.integral.q + gain_q * error.q + electrical_speed * (self.inductance_d * own.d + self.flux),
        )
        made = limited_voltage(asked, longest)
        growth = period / self.lag * self.resistance
        integral = RotorVector(
            memory.integral.d + growth * (error.d + (made.d - asked.d) / gain_d),
            memory.integral.q + growth * (error.q + (made.q - asked.q) / gain_q),
        )
        ahead = turned(rotor, 1.5 * period * electrical_speed)
        return ControlMemory(integral, angle, speed, inverse_park(made, ahead))

    def _speed(self, memory: ControlMemory, angle: Scalar, period: Scalar) -> Scalar:
        keep = exp(-period / (self.speed_time + 1e-9 * period))
        return keep * memory.speed + (1.0 - keep) / period * (angle - memory.angle)
