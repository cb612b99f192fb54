"""Current control of the motor and its set points, with flux weakening."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import absolute, exp, limit, maximum, minimum, sqrt
from tierod.physics.motor import Direction, RotorVector, StatorVector, inverse_park, park, torque_constant, turned
from tierod_lab.ground.laws import limited_voltage

_ROUNDS = 6  # Number of iterations in the search for the current that makes a torque


@dataclass(frozen=True)
class SetPoints:
    """Currents along and across the flux for a torque, from the motor parameters of the control unit.

    Args:
        inductance_d, inductance_q: inductances along and across the flux [H]
        flux: flux linkage of the magnets [V*s]
        current_limit: maximum length of the current vector [A]

    Source: Morimoto et al., IEEE Trans. Industry Applications 26 (1990) 866: maximum torque per ampere, and above the
    speed of the voltage limit the current along the flux that keeps the voltage at its limit; resistance neglected.
    """

    inductance_d: float
    inductance_q: float
    flux: float
    current_limit: float

    def of(self, wanted: Any, electrical_speed: Any, longest: Any) -> RotorVector:
        """Current set points in the rotor's axes [A].

        Args:
            wanted: current across the flux that would make the torque with the magnets alone [A]
            electrical_speed: electrical speed [rad/s]
            longest: maximum voltage for these currents [V]
        """
        along: Any = 0.0
        # Under-relaxed fixed-point iteration, with a fixed number of rounds so that it can be traced into a program.
        for _ in range(_ROUNDS):
            along = 0.5 * (along + self._least(self._across(wanted, along)))
        linkage = longest / maximum(absolute(electrical_speed), 1.0)
        room = sqrt(maximum(linkage * linkage - (self.inductance_q * self._across(wanted, along)) ** 2, 0.0))
        along = maximum(minimum(along, (room - self.flux) / self.inductance_d), -self.current_limit)
        left = sqrt(maximum(linkage * linkage - (self.flux + self.inductance_d * along) ** 2, 0.0)) / self.inductance_q
        most = minimum(sqrt(maximum(self.current_limit**2 - along * along, 0.0)), left)
        return RotorVector(along, limit(self._across(wanted, along), -most, most))

    def _across(self, wanted: Any, along: Any) -> Any:
        return self.flux * wanted / (self.flux - (self.inductance_q - self.inductance_d) * along)

    def _least(self, across: Any) -> Any:
        """Current along the flux that gives, with a current across it, maximum torque per ampere [A]."""
        apart = (self.inductance_q - self.inductance_d) * across
        return -2.0 * apart * across / (self.flux + sqrt(self.flux * self.flux + 4.0 * apart * apart))


class ControlMemory(NamedTuple):
    """State of the control unit."""

    integral: RotorVector  # integral of the current error, as voltage [V]
    angle: Scalar  # mechanical angle sensed at the previous sample [rad]
    speed: Scalar  # mechanical speed, from the sensed angle [rad/s]
    command: StatorVector  # voltage command of the inverter for the next period [V]


@dataclass(frozen=True)
class CurrentControl:
    """Proportional-integral control in the rotor's axes with feed-forward of the induced voltages.

    The inverter applies the command of a sample in the next period, as in every digital drive; the command is rotated
    by the angle through which the rotor turns until then. The motor parameters of the control unit are its own and may
    differ from the true ones.
    """

    resistance: Annotated[float, "ohm", POSITIVE] = 0.05
    inductance_d: Annotated[float, "H", POSITIVE] = 1e-4
    inductance_q: Annotated[float, "H", POSITIVE] = 1e-4
    flux: Annotated[float, "V*s", POSITIVE] = 0.0085
    # time constant of the closed current loop; 1/3 ms tolerates a delay of one and a half periods at 10 kHz
    lag: Annotated[float, "s", POSITIVE] = 1.0 / 3000.0
    current_limit: Annotated[float, "A", POSITIVE] = 60.0
    # time constant of the low-pass on the sensed speed; 0 is none
    speed_time: Annotated[float, "s", NOT_NEGATIVE] = 5e-4
    # share of the maximum voltage that `SetPoints` may use when they choose the d-axis current; None sets no d-axis
    # current
    weakening: Annotated[float, "", SHARE] | None = None

    def remembered(self) -> ControlMemory:
        return ControlMemory(RotorVector(0.0, 0.0), 0.0, 0.0, StatorVector(0.0, 0.0))

    def wanted_current(self, torque: Scalar, pole_pairs: int) -> Scalar:
        """Current across the flux [A] for a shaft torque [N*m], within the limit; none flows along the flux."""
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
        # Back-calculation: the voltage that the inverter cannot make is subtracted at the input of the integral.
        growth = period / self.lag * self.resistance
        integral = RotorVector(
            memory.integral.d + growth * (error.d + (made.d - asked.d) / gain_d),
            memory.integral.q + growth * (error.q + (made.q - asked.q) / gain_q),
        )
        # The voltage acts during the next period, whose middle is one and a half periods after the sample.
        ahead = turned(rotor, 1.5 * period * electrical_speed)
        return ControlMemory(integral, angle, speed, inverse_park(made, ahead))

    def _speed(self, memory: ControlMemory, angle: Scalar, period: Scalar) -> Scalar:
        # The small second term permits a time constant of zero.
        keep = exp(-period / (self.speed_time + 1e-9 * period))
        return keep * memory.speed + (1.0 - keep) / period * (angle - memory.angle)
