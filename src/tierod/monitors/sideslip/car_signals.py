"""From the signals of a car to those that a sideslip estimator reads."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, Self

from tierod.core.block import Block, Tree, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import present, where
from tierod.core.signals import SIGNALS
from tierod.models.steer_by_wire import Actuator
from tierod.vehicles.vehicle import Vehicle

MADE = {
    "road_wheel_angle": ("road_wheel_angle", "steering_wheel_angle"),
    "road_wheel_torque": ("motor_torque", "motor_current"),
}
"""What an estimator reads -> signals of the car that it is made of."""

BY_WIRE = "gearhead_ratio"
"""A vehicle file that gives this parameter describes a car steered by wire."""


@dataclass(frozen=True)
class Ratio:
    """Angle of the road wheels over that of the steering wheel.

    Args:
        steering_ratio: road wheels over steering wheel
    """

    steering_ratio: Annotated[float, ""]


@dataclass(frozen=True)
class FromCarSignals:
    """A sideslip estimator that is fed with the signals of a car.

    The angle of the road wheels is the measured one, or else the steering wheel's times the ratio; their torque comes
    from the motor's torque, or else from its current. A signal that the car lacks is NaN, and so is what is made of it.

    Args:
        estimator: any sideslip block, see `tierod.monitors.sideslip.session`
        ratio: of the steering
        actuator: of a car steered by wire; None where the torque at the road wheels is not known
    """

    estimator: Block
    ratio: Ratio
    actuator: Actuator | None

    @classmethod
    def of_vehicle(cls, estimator: Block, vehicle: Vehicle) -> Self:
        """The estimator with ratio and actuator of a vehicle file.

        Raises:
            ParameterError: the file lacks one of them
        """
        actuator = vehicle.parameters_for(Actuator) if BY_WIRE in vehicle else None
        return cls(estimator, vehicle.parameters_for(Ratio), actuator)

    @property
    def Sample(self) -> type:
        """NamedTuple class of the car's signals that the estimator needs."""
        return _sample_class(self.estimator.Sample._fields)  # type: ignore[attr-defined]

    def init(self) -> Tree:
        """Of the estimator."""
        return self.estimator.init()

    def step(self, state: Tree, sample: Any) -> tuple[Tree, Tree]:
        """One sample on; the output is the estimator's."""
        kind: Any = self.estimator.Sample
        return self.estimator.step(state, kind(*(self._read(name, sample) for name in kind._fields)))

    def _read(self, name: str, sample: Any) -> Any:
        if name == "road_wheel_angle":
            of_wheel = self.ratio.steering_ratio * sample.steering_wheel_angle
            return where(present(sample.road_wheel_angle), sample.road_wheel_angle, of_wheel)
        if name == "road_wheel_torque":
            if self.actuator is None:
                return math.inf
            of_current = self.actuator.motor_torque(sample.motor_current)
            torque = where(present(sample.motor_torque), sample.motor_torque, of_current)
            return self.actuator.road_wheel_torque(torque)
        return getattr(sample, name)


@lru_cache(maxsize=64)
def _sample_class(fields: tuple[str, ...]) -> type:
    names = dict.fromkeys(signal for name in fields for signal in MADE.get(name, (name,)))
    if strange := [name for name in names if name not in SIGNALS]:
        raise ParameterError(f"a sideslip estimator reads '{strange[0]}', which is no canonical signal")
    return named_tuple("CarSample", [(name, Annotated[float, SIGNALS[name].unit]) for name in names])
