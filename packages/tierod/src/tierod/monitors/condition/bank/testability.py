"""Testability of faults in a sample: with the available sensors, and in a motion that the filters describe."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, any_of, both, either, maximum, negated, present, where
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.weighing import Weighing
from tierod.monitors.condition.signals import ALL_WHEELS, ELEMENTS, NEEDED, OF_AUTOMATED, SENSORS, Elements


class Open(NamedTuple):
    """Hypotheses that are observable with the remaining sensors.

    Args:
        hypotheses: whether each hypothesis may be declared
        widening: factor on all limits
    """

    hypotheses: list[Scalar]
    widening: Scalar


@dataclass(frozen=True)
class Testability:
    """Decide which hypotheses may be declared, and which faults would show.

    No fault is declared at standstill and in reverse, no fault of a wheel while the vehicle brakes harder than with its
    drives, none of a missing sensor, and none of a steering motor without the sensor of the torque of both motors.

    Args:
        shows: number of standard deviations of the prediction by which a fault must change a reading to show
        missing: time without a reading after which a sensor is missing; longer than the interval of the slowest channel
        poorer: factor on all limits while a sensor is missing; fault-free ratios are up to 1.7 times as large then
        fewest: least number of available sensors for any declaration
        remaining: least number of sensors that a hypothesis leaves: two give speed and yaw rate, a third checks them
        judged: sensors that the vehicle has
        cornering: lateral acceleration from which no fault is declared, since tyres may slide as in no calibration
            drive; those of the demonstrator reach 5.9 m/s**2
        stays: time for which no fault is declared afterwards, and after an axle lacked force in that bend; the filters
            recover in it
        surely: factor on the change whose first sample exceeds the limit, for a change that is seen while it lasts:
            filters that use the sensor follow it in part, and no other hypothesis may explain it as well. Of injected
            changes of ten seconds, nine of ten are seen (virtual cars and demonstrators of seeds 101 to 104)
        followed: the same for the yaw rate and the steering angle, whose offsets are states of the filters
    """

    shows: Annotated[float, ""] = 4.0
    missing: Annotated[float, "s"] = 0.2
    poorer: Annotated[float, ""] = 1.7
    fewest: Annotated[float, ""] = 4.0
    remaining: Annotated[float, ""] = 2.0
    judged: tuple[str, ...] = OF_AUTOMATED
    cornering: Annotated[float, "m/s**2"] = 6.5
    stays: Annotated[float, "s"] = 0.5
    surely: Annotated[float, ""] = 2.0
    followed: Annotated[float, ""] = 2.5

    def multiple(self, weighing: Weighing, name: str) -> float:
        """Smallest lasting change of an element that is seen, in standard deviations of its prediction by the others.

        A change of x of them has a log-likelihood ratio of x^2 / 2 less the cost of leaving out the sensor.

        Args:
            weighing: weighing of the hypotheses, with their limits and costs
            name: element with a hypothesis of its own
        """
        number = weighing.number(name)
        assert number is not None
        cost = weighing.prices[SENSORS.index(name)] if name in SENSORS else 0.0
        factor = self.followed if name in ("yaw_rate", "steering_wheel_angle") else self.surely
        return factor * math.sqrt(2.0 * (cost + weighing.limits.fast[number - 1]))

    def cornered(self, before: Scalar, acceleration: Scalar, lacks: Scalar, sample_time: float) -> Scalar:
        """Number of samples for which tyres may still slide; without the acceleration no hard cornering is detected.

        Args:
            before: number after the previous sample
            acceleration: lateral acceleration; NaN if missing
            lacks: whether an axle lacks force, which prolongs a slide that has begun
            sample_time: sampling interval [s]
        """
        hard = absolute(where(present(acceleration), acceleration, 0.0)) > self.cornering
        return where(either(hard, both(before > 0.5, lacks)), self.stays / sample_time, maximum(before - 1.0, 0.0))

    def counting(self, weighing: Weighing, seen: LeaveOutFilter.Output, follows: Scalar) -> list[Scalar]:
        """Whether a sample may count for each hypothesis: only if `follows`, for wheels only without braking."""
        braked = both(follows, seen.driven)
        return [braked if {*ALL_WHEELS} & {*each.sensors} else follows for each in weighing.hypotheses]

    def open(self, weighing: Weighing, unread: Sequence[Scalar], suspected: Elements) -> Open:
        """Hypotheses that may be declared with the available sensors.

        Args:
            weighing: weighing of the hypotheses
            unread: number of samples without a reading of each sensor
            suspected: declared elements
        """
        most = self.missing / weighing.sample_time
        gone = {name: where(unread[SENSORS.index(name)] > most, 1.0, 0.0) for name in self.judged}
        newly = {name: both(each, negated(getattr(suspected, name))) for name, each in gone.items()}
        there = [1.0 - each for each in gone.values()]
        left = sum(there[1:], there[0])
        open_ = []
        for each in weighing.hypotheses:
            needed = {*each.sensors, *(NEEDED[name] for name in each.actuators if name in NEEDED)}
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
    ) -> tuple[Elements, Elements]:
        """Whether a total loss of each element would show and may be declared, and the deviations that decide it.

        It shows if the predicted reading is far enough from zero, or the lost share of torque is known well enough.

        Args:
            weighing: weighing of the hypotheses
            lanes: outputs of all lanes
            suspected: declared elements
            seen: output of the selected lane
            open_: whether each hypothesis may be declared
        """
        flags, spread = [], []
        for place, name in enumerate(ELEMENTS):
            # An element that the vehicle lacks takes lane 0, which predicts 0 for it: it never counts as testable.
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
            spread.append(deviation)
        return Elements(*(where(flag, 1.0, 0.0) for flag in flags)), Elements(*spread)
