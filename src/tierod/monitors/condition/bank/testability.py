"""Testability of faults in this sample: with the available sensors, in motion that the filters follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, any_of, both, either, maximum, negated, present, where
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.weighing import Weighing
from tierod.monitors.condition.signals import ALL_WHEELS, ELEMENTS, OF_AUTOMATED, SENSORS, Elements

TOLD_BY = {"steering_motor_1": "steering_shaft_torque", "steering_motor_2": "steering_shaft_torque"}


class Open(NamedTuple):
    """Observability with the sensors that are left.

    Args:
        hypotheses: whether each one may be declared
        widening: factor of all limits
    """

    hypotheses: list[Scalar]
    widening: Scalar


@dataclass(frozen=True)
class Testability:
    """Hypotheses that may be declared, and whether a fault would show.

    No fault is declared at standstill and in reverse, none of a wheel while the vehicle brakes harder than its drives,
    none of a sensor that is missing, and none of a steering motor without the sensor of the torque that both give.

    Args:
        shows: number of standard deviations of its prediction by which a fault must change a reading to show in it
        missing: after which a sensor without a reading is missing: longer than the slowest channels take
        poorer: factor of all limits while one is: what is left shows up to 1.7 times as much without any fault
        fewest: sensors without which no fault is declared
        remaining: sensors that a hypothesis must leave to be declared: two give speed and yaw rate, a third checks them
        judged: sensors that the vehicle has
        cornering: acceleration across the vehicle from which no fault is declared: tyres slide, and no calibration
            drive has shown how; those of the demonstrator reach 5.9 m/s**2
        stays: so long none is, after that or after an axle lacked force in that bend: the filters have to find back
    """

    shows: Annotated[float, ""] = 4.0
    missing: Annotated[float, "s"] = 0.2
    poorer: Annotated[float, ""] = 1.7
    fewest: Annotated[float, ""] = 4.0
    remaining: Annotated[float, ""] = 2.0
    judged: tuple[str, ...] = OF_AUTOMATED
    cornering: Annotated[float, "m/s**2"] = 6.5
    stays: Annotated[float, "s"] = 0.5

    def cornered(self, before: Scalar, acceleration: Scalar, lacks: Scalar, sample_time: float) -> Scalar:
        """Number of samples for which the tyres may slide, with this one; without the acceleration no bend is detected.

        Args:
            before: the same at the sample before
            acceleration: across the vehicle
            lacks: whether an axle lacks force; tyres that slid then still do
            sample_time: [s]
        """
        hard = absolute(where(present(acceleration), acceleration, 0.0)) > self.cornering
        return where(either(hard, both(before > 0.5, lacks)), self.stays / sample_time, maximum(before - 1.0, 0.0))

    def counting(self, weighing: Weighing, seen: LeaveOutFilter.Output, follows: Scalar) -> list[Scalar]:
        """Whether this sample may count for each hypothesis: nothing does unless `follows`, braked wheels may lock."""
        braked = both(follows, seen.driven)
        return [braked if {*ALL_WHEELS} & {*each.sensors} else follows for each in weighing.hypotheses]

    def open(self, weighing: Weighing, unread: Sequence[Scalar], suspected: Elements) -> Open:
        """Hypotheses that may be declared with the sensors that are left.

        Args:
            weighing: of the hypotheses
            unread: for how many samples each sensor has had no reading
            suspected: declared elements
        """
        most = self.missing / weighing.sample_time
        gone = {name: where(unread[SENSORS.index(name)] > most, 1.0, 0.0) for name in self.judged}
        newly = {name: both(each, negated(getattr(suspected, name))) for name, each in gone.items()}
        there = [1.0 - each for each in gone.values()]
        left = sum(there[1:], there[0])
        open_ = []
        for each in weighing.hypotheses:
            needed = {*each.sensors, *(TOLD_BY[name] for name in each.actuators if name in TOLD_BY)}
            enough = both(left >= self.fewest, left >= self.remaining + float(len(each.sensors)))
            open_.append(all_of(enough, *(negated(newly[name]) for name in self.judged if name in needed)))
        return Open(open_, where(any_of(0.0, *newly.values()), self.poorer, 1.0))

    def testable(
        self,
        weighing: Weighing,
        lanes: Sequence[LeaveOutFilter.Output],
        suspected: Elements,
        seen: LeaveOutFilter.Output,
        open_: Sequence[Scalar],
    ) -> Elements:
        """Whether a loss would show: a reading far enough from zero, a share of torque known well; and may be declared.

        Args:
            weighing: of the hypotheses
            lanes: outputs of all
            suspected: declared elements
            seen: output of the selected lane
            open_: whether each hypothesis may be declared
        """
        flags = []
        for place, name in enumerate(ELEMENTS):
            number = weighing.number(name) or 0
            own = lanes[number]
            if name in SENSORS:
                away = where(suspected[place], seen.prediction[place], own.prediction[place])
                deviation = where(suspected[place], seen.deviation[place], own.deviation[place])
                shows = absolute(away) > self.shows * deviation
            else:
                deviation = where(suspected[place], seen.loss_deviation, own.loss_deviation)
                shows = self.shows * deviation < 1.0
            flags.append(both(shows, open_[number]))
        return Elements(*(where(flag, 1.0, 0.0) for flag in flags))
