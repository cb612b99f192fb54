"""A car with electric power steering, the virtual test vehicle of the friction and column monitors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.proving_ground.cars.car import Car, Observed
from tierod.proving_ground.control.assist import AssistUnit
from tierod.proving_ground.parts import Steering
from tierod.proving_ground.steering.column_eps import ColumnEps


class Assisted(NamedTuple):
    """Signals of the assist unit."""

    motor_target_torque: Annotated[Any, "N*m"]


@dataclass(frozen=True)
class EpsCar(Car):
    """Chassis, EPS steering, driver and assist unit; the steering is a `ColumnEps` or a `RackEps`.

    Args:
        assist: control unit of the motor
    """

    steering: Steering = field(default_factory=ColumnEps)
    assist: AssistUnit = field(default_factory=AssistUnit)

    @property
    def ports(self) -> tuple[str, ...]:
        """What the assist unit reads, and its motor."""
        return (
            "driver_torque",
            "steering_wheel_angle",
            "steering_wheel_rate",
            "vehicle_speed",
            *self.steering.actuators,
        )

    def reset(self) -> Any:
        """Memory of the assist unit."""
        return self.assist.remembered()

    def control(self, memory: Any, seen: Observed, read: Callable[[str, Any], Any]) -> tuple[Any, tuple, Any]:
        """The assist unit's step."""
        memory, torque = self.assist.decide(
            memory,
            read("driver_torque", seen.steering.driver_torque),
            read("vehicle_speed", seen.vehicle_speed),
            read("steering_wheel_angle", seen.hand.angle),
            read("steering_wheel_rate", seen.hand.rate),
        )
        return memory, (torque,), Assisted(torque)
