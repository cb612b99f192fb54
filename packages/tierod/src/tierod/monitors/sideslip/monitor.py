"""The block of the monitor: a sideslip estimator with the signals of a car as input and a statement as output.

Requirements on an estimator to be a variant of the monitor:

- `Sample`: a flat NamedTuple of canonical signals. `road_wheel_angle` is computed from the steering wheel angle where
  it is not measured, `road_wheel_torque` from the motor's torque or current; all others are passed on, NaN where the
  car lacks them.
- an output with the fields of `SideslipEstimate`; further fields can be shown over time by `SideslipSession`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple, Self

from tierod.core.block import Block, Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.findings import Status
from tierod.core.graph.maths import present, where
from tierod.core.signals import SIGNALS
from tierod.core.statement import Statement, code_of
from tierod.models.steer_by_wire import Actuator
from tierod.monitors.sideslip.combined_tuning import BY_WIRE
from tierod.vehicles.vehicle import Vehicle

MADE = {
    "road_wheel_angle": ("road_wheel_angle", "steering_wheel_angle"),
    "road_wheel_torque": ("motor_torque", "motor_current"),
}
"""Input of an estimator -> signals of the car that it is computed from."""

class SideslipEstimate(NamedTuple):
    """Output of every sideslip block after a sample.

    Args:
        sideslip_angle, sideslip_angle_deviation: sideslip at the centre of gravity, and its standard deviation
        self_aligning_torque, self_aligning_torque_deviation: torque of the front tyres, opposing positive steer
        nis, readings: normalised innovation squared of the sample, and its number of readings
        held: 1 where nothing could be estimated and the last estimate is held
    """

    sideslip_angle: Annotated[float, "rad"]
    sideslip_angle_deviation: Annotated[float, "rad"]
    self_aligning_torque: Annotated[float, "N*m"]
    self_aligning_torque_deviation: Annotated[float, "N*m"]
    nis: Annotated[float, ""]
    readings: Annotated[float, ""]
    held: Annotated[float, ""]


@dataclass(frozen=True)
class Ratio:
    """Angle of the road wheels over that of the steering wheel.

    Args:
        steering_ratio: road wheels over steering wheel
    """

    steering_ratio: Annotated[float, ""]


@dataclass(frozen=True)
class SideslipMonitor:
    """A sideslip estimator with the signals of a car as input, and the statement on its estimate.

    The angle of the road wheels is the measured one, or else the steering wheel's times the ratio; their torque comes
    from the motor's torque, or else from its current. A missing signal is NaN; inputs computed from it are missing too.

    Args:
        estimator: the estimator, see the module
        ratio: steering ratio
        actuator: actuator of a car steered by wire; None where the torque at the road wheels is unknown
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

    class Output(NamedTuple):
        """Sideslip angle at the centre of gravity [rad] as a statement, and the output of the estimator.

        It is estimated where the sideslip was estimated, not enabled where the last estimate is held; its kind
        is 1 where the front axle nears its limit, its evidence the distance from that limit.
        """

        statement: Statement
        estimate: Tree

    @property
    def Sample(self) -> type:
        """NamedTuple class of the car's signals that the estimator needs."""
        return _sample_class(_fields(self.estimator.Sample))

    def init(self) -> Tree:
        """State of the estimator before the first sample."""
        return self.estimator.init()

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Output]:
        """Process one sample."""
        kind = self.estimator.Sample
        after, estimate = self.estimator.step(state, kind(*(self._read(name, sample) for name in _fields(kind))))
        statement = Statement(
            status=where(estimate.held > 0.5, code_of(Status.NOT_ENABLED), code_of(Status.ESTIMATED)),
            since=-1.0,
            kind=getattr(estimate, "limit_ahead", 0.0),
            magnitude=estimate.sideslip_angle,
            deviation=estimate.sideslip_angle_deviation,
            evidence=getattr(estimate, "limit_distance", 0.0),
        )
        return after, self.Output(statement, estimate)

    def _read(self, name: str, sample: Tree) -> Scalar:
        if name == "road_wheel_angle":
            of_wheel = self.ratio.steering_ratio * sample.steering_wheel_angle
            angle: Scalar = where(present(sample.road_wheel_angle), sample.road_wheel_angle, of_wheel)
            return angle
        if name == "road_wheel_torque":
            if self.actuator is None:
                return math.inf
            of_current = self.actuator.motor_torque(sample.motor_current)
            of_motor = where(present(sample.motor_torque), sample.motor_torque, of_current)
            torque: Scalar = self.actuator.road_wheel_torque(of_motor)
            return torque
        value: Scalar = getattr(sample, name)
        return value


def _fields(kind: type) -> tuple[str, ...]:
    """Names of the fields of a NamedTuple class."""
    names: tuple[str, ...] = getattr(kind, "_fields", ())
    return names


@lru_cache(maxsize=64)
def _sample_class(fields: tuple[str, ...]) -> type:
    names = dict.fromkeys(signal for name in fields for signal in MADE.get(name, (name,)))
    if strange := [name for name in names if name not in SIGNALS]:
        raise ParameterError(f"a sideslip estimator reads '{strange[0]}', which is no canonical signal")
    return named_tuple("CarSample", [(name, Annotated[float, SIGNALS[name].unit]) for name in names])
