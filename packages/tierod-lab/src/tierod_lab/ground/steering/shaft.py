"""Components on the shaft of a steering: torsion bar and electric motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit
from tierod.physics.steering_ratio import torsion_bar_torque
from tierod_lab.ground.steering.motor_torque import driving_limit, torque_ripple


class Wheel(NamedTuple):
    """Motion of a steering wheel that a torsion bar separates from the column."""

    angle: Scalar
    rate: Scalar


@dataclass(frozen=True)
class TorsionBar:
    """Elastic torsion bar below the steering wheel; 140 N*m/rad is 2.4 N*m per degree."""

    stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.05

    def torque(self, wheel: Wheel, angle: Scalar, rate: Scalar) -> Scalar:
        """Torque on the column [N*m]."""
        return torsion_bar_torque(wheel.angle, angle, self.stiffness, wheel.rate, rate, self.damping)


@dataclass(frozen=True)
class Ripple:
    """Cogging torque and torque ripple over the rotor angle, see `motor_torque`; of a good EPS motor."""

    cogging_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.01
    share: Annotated[float, "", NOT_NEGATIVE] = 0.01
    order: Annotated[float, "", POSITIVE] = 24.0


def rippled(torque: Scalar, angle: Scalar, ripple: Ripple | None) -> Scalar:
    """Shaft torque [N*m] for an electromagnetic torque [N*m] at a rotor angle [rad]."""
    if ripple is None:
        return torque
    return torque + torque_ripple(angle, torque, ripple.cogging_torque, ripple.share, ripple.order)


@dataclass(frozen=True)
class SpeedLimit:
    """Torque limit due to the voltage at high speed, see `tierod_lab.ground.steering.motor_torque`.

    The defaults are typical: with a ratio of 20, full torque up to 430 degrees of column per second, none at 1000.
    """

    base_speed: Annotated[float, "rad/s", POSITIVE] = 150.0
    no_load_speed: Annotated[float, "rad/s", POSITIVE] = 350.0

    def __post_init__(self) -> None:
        if not self.no_load_speed > self.base_speed:
            raise ParameterError(
                f"a motor without load turns at {self.no_load_speed:g} rad/s, which is not above its base speed of "
                f"{self.base_speed:g} rad/s; raise no_load_speed"
            )


@dataclass(frozen=True)
class Motor:
    """Electric motor at its shaft; typical of a mid-size car with 60 N*m of assist at the column."""

    ratio: Annotated[float, "", POSITIVE] = 20.0
    inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.5e-4
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 2e-3
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 3.5
    ripple: Ripple | None = None  # None for a smooth motor
    speed_limit: SpeedLimit | None = None  # None for a motor without voltage limit

    def torque_rate(self, torque: Scalar, request: Scalar, speed: Scalar = 0.0) -> Scalar:
        """Rate of change of the electromagnetic torque [N*m/s].

        Args:
            torque: electromagnetic torque [N*m]
            request: requested torque [N*m]
            speed: speed of the rotor [rad/s]
        """
        # Only the torque that drives the rotor is limited by the voltage, so each sign has its own limit.
        return (limit(request, -self._most(-speed), self._most(speed)) - torque) / self.lag

    def _most(self, speed: Scalar) -> Scalar:
        if self.speed_limit is None:
            return self.maximum_torque
        return driving_limit(speed, self.maximum_torque, self.speed_limit.base_speed, self.speed_limit.no_load_speed)

    def shaft_torque(self, torque: Scalar, angle: Scalar) -> Scalar:
        """Shaft torque [N*m] at a rotor angle [rad]."""
        return rippled(torque, angle, self.ripple)


def assist_motor() -> Motor:
    """Typical motor of an EPS, with its voltage limit."""
    return Motor(speed_limit=SpeedLimit())
