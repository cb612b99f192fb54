"""Weighing of the hypotheses by their likelihoods, and which of their faults can be declared or withdrawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    either,
    greatest_of,
    maximum,
    minimum,
    negated,
    present,
    where,
)
from tierod.monitors.condition.signals import ALL_WHEELS, ELEMENTS, NEEDED, OF_AUTOMATED, SENSORS, Elements, Hypothesis
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.physics.friction import share_reached

NEVER = -1e9  # score of a hypothesis that cannot be chosen; far below any ratio


@dataclass(frozen=True)
class Limits:
    """Limits of the log-likelihood ratios, designed on fault-free drives."""

    # fast, slow: limit of the mean ratio against the active hypothesis over the short and the long time, for each
    # hypothesis but the fault-free one, in their order [nat]; above 0, so that missing readings exceed none
    fast: tuple[Annotated[float, ""], ...]
    slow: tuple[Annotated[float, ""], ...]
    # least lead of the best hypothesis over all that neither contain it nor are contained in it [nat]
    gap: Annotated[float, ""]
    margin: Annotated[float, ""]  # least additional ratio of a hypothesis per suspect beyond the first [nat]


class Weights(NamedTuple):
    """Smoothed log-likelihood ratios of all hypotheses against the active one [nat per sample]."""

    fast: tuple[Scalar, ...]
    slow: tuple[Scalar, ...]


class Ranking(NamedTuple):
    """Ranking of the hypotheses after one sample."""

    exceeding: Scalar  # whether any other hypothesis exceeds its limit
    best: Scalar  # number of the best of these
    # score of the best less that of the best rival [nat]; 0 while a rival scores higher without the costs of leaving
    # out sensors
    lead: Scalar
    # for each hypothesis, whether it explains the samples about as well as the best, which is included
    rivals: tuple[Scalar, ...]


@dataclass(frozen=True)
class Weighing:
    """Ratios and ranking of the hypotheses of a bank.

    Args:
        hypotheses: hypotheses in the order of the lanes, the fault-free one first
        sample_time: sampling interval [s]
        largest: bound of the ratio of a single sample [nat], so that a single outlier declares nothing; some three
            times the cost of leaving out a sensor
        prices: cost of leaving out each sensor per fault-free sample [nat]; see `tuning.prices`

    A slowly growing error biases all other estimates at little cost in likelihood per sample, while leaving out the
    faulty sensor costs its whole price; a hypothesis with a cheaper sensor then leads. Hence the best hypothesis must
    also lead after the prices have been credited.
    """

    hypotheses: tuple[Hypothesis, ...]
    limits: Limits
    sample_time: Annotated[float, "s"] = 0.01
    fast_time: Annotated[float, "s"] = 0.05
    slow_time: Annotated[float, "s"] = 0.5
    largest: Annotated[float, ""] = 20.0
    prices: tuple[Annotated[float, ""], ...] = (0.0,) * len(SENSORS)

    def __post_init__(self) -> None:
        for name in ("fast", "slow"):
            given = len(getattr(self.limits, name))
            if given != len(self.hypotheses) - 1:
                raise ParameterError(
                    f"{given} {name} limits were given for {len(self.hypotheses) - 1} hypotheses beside the healthy "
                    "one; give one for each, in their order"
                )

    def init(self) -> Weights:
        zeros = (0.0,) * len(self.hypotheses)
        return Weights(zeros, zeros)

    def smoothed(
        self, weights: Weights, likelihoods: Sequence[Scalar], active: Scalar, counting: Sequence[Scalar] | None = None
    ) -> Weights:
        best = greatest_of(*likelihoods)
        limited = [maximum(value, best - self.largest) for value in likelihoods]
        own = chosen(limited, active)
        ratios = [value - own for value in limited]
        if counting is not None:
            ratios = [where(counts, ratio, minimum(ratio, 0.0)) for counts, ratio in zip(counting, ratios, strict=True)]
        shares = [share_reached(self.sample_time / time) for time in (self.fast_time, self.slow_time)]
        return Weights(*(_on(mean, ratios, share) for mean, share in zip(weights, shares, strict=True)))

    def restarted(self, weights: Weights, active: Scalar, changed: Scalar) -> Weights:
        """Weights after a change of the active hypothesis, which discards the evidence in favour of all others.

        In the long mean, evidence against hypotheses that leave out a sensor is kept, since their cost continues.
        Without it, a bump of the road at that moment would suffice to declare a second fault.
        """
        own = chosen(weights.slow, active)
        against = [
            minimum(mean - own, 0.0) if each.sensors else 0.0
            for mean, each in zip(weights.slow, self.hypotheses, strict=True)
        ]
        fast = tuple(where(changed, 0.0, mean) for mean in weights.fast)
        slow = tuple(where(changed, kept, mean) for kept, mean in zip(against, weights.slow, strict=True))
        return Weights(fast, slow)

    def ranking(
        self, weights: Weights, active: Scalar, widening: Scalar = 1.0, observable: Sequence[Scalar] | None = None
    ) -> Ranking:
        holds = [active == number for number in range(len(self.hypotheses))]
        allowed = [self._is_new(number, holds) for number in range(len(self.hypotheses))]
        scores = [
            fast + slow - self.limits.margin * max(len(each.suspects) - 1, 0)
            for fast, slow, each in zip(weights.fast, weights.slow, self.hypotheses, strict=True)
        ]
        beyond = [
            both(allowed[number], self._is_beyond(number, weights, holds, widening)) if number else 0.0
            for number in range(len(self.hypotheses))
        ]
        best, top = _highest(scores, beyond)
        chosen_one = [best == number for number in range(len(self.hypotheses))]
        rivals = [
            both(allowed[number], negated(any_of(0.0, *(chosen_one[other] for other in self._related(number)))))
            if number
            else 0.0
            for number in range(len(self.hypotheses))
        ]
        _, second = _highest(scores, rivals)
        # A score is the sum of two means, each of which contains the cost of the left-out sensor.
        net = [
            score + 2.0 * self._exclusion_credit(each, holds)
            for score, each in zip(scores, self.hypotheses, strict=True)
        ]
        own = chosen(net, best)
        _, other = _highest(
            net, rivals if observable is None else [both(*pair) for pair in zip(rivals, observable, strict=True)]
        )
        near = [either(top - score < self.limits.gap, each > own) for score, each in zip(scores, net, strict=True)]
        close = [
            either(chosen_one[number], all_of(rivals[number], beyond[number], near[number]))
            for number in range(len(self.hypotheses))
        ]
        exceeding = any_of(0.0, *beyond[1:])
        lead = where(own > other, top - second, 0.0)
        return Ranking(exceeding, best, lead, tuple(both(exceeding, each) for each in close))

    def number(self, *suspects: str) -> int | None:
        """Number of the hypothesis that suspects exactly these elements; None if there is none."""
        for number, each in enumerate(self.hypotheses):
            if set(each.suspects) == set(suspects):
                return number
        return None

    def naming(self, element: str) -> list[int]:
        """Numbers of the hypotheses that suspect an element, alone or with others."""
        return [number for number, each in enumerate(self.hypotheses) if element in each.suspects]

    def _is_new(self, number: int, holds: Sequence[Scalar]) -> Scalar:
        """Whether a hypothesis may follow the active one: it must suspect all sensors of it, and something else.

        A declared sensor is kept, since a lost one agrees with its prediction while the true value is near zero. A
        wrongly declared one recovers once the right one is suspected as well.
        """
        own = self.hypotheses[number]
        before = [
            holds[k]
            for k, each in enumerate(self.hypotheses)
            if {*each.sensors} <= {*own.suspects} and not ({*own.suspects} <= {*each.suspects} and own.agrees(each))
        ]
        return any_of(0.0, *before)

    def _exclusion_credit(self, hypothesis: Hypothesis, holds: Sequence[Scalar]) -> Scalar:
        """Cost of the sensor that a hypothesis leaves out in addition to the active one; 0 for two at once."""
        prices = [self.prices[SENSORS.index(name)] if name in SENSORS else 0.0 for name in hypothesis.suspects]
        if len(prices) < 2:
            return prices[0] if prices else 0.0
        credit: Scalar = 0.0
        for name, other in zip(hypothesis.suspects, reversed(prices), strict=True):
            known = self.number(name)
            if known is not None:
                credit = where(holds[known], other, credit)
        return credit

    def _is_beyond(self, number: int, weights: Weights, holds: Sequence[Scalar], widening: Scalar) -> Scalar:
        """Whether a hypothesis exceeds its limit; with one of two suspects active, that of the other one applies."""
        fast, slow = self._limits_of(number)
        suspects = self.hypotheses[number].suspects
        for known in suspects if len(suspects) > 1 else ():
            single, others = self.number(known), self.number(*(name for name in suspects if name != known))
            if single is not None and others is not None:
                own = self._limits_of(others)
                fast, slow = where(holds[single], own[0], fast), where(holds[single], own[1], slow)
        return either(weights.fast[number] > widening * fast, weights.slow[number] > widening * slow)

    def _limits_of(self, number: int) -> tuple[Scalar, Scalar]:
        return self.limits.fast[number - 1], self.limits.slow[number - 1]

    def _related(self, number: int) -> list[int]:
        """Hypotheses that contain this one or are contained in it, without the fault-free one.

        The loss of a single actuator does not count as contained in the joint loss of two: it remains a rival of that.
        The joint loss is no rival of the single one, which explains the same with less.
        """
        own = self.hypotheses[number]
        return [
            k
            for k, each in enumerate(self.hypotheses)
            if k and ((own.agrees(each) and {*own.suspects} <= {*each.suspects}) or {*own.suspects} >= {*each.suspects})
        ]


def chosen(values: Sequence[Scalar], number: Scalar) -> Scalar:
    """One of several values, by a number that is known at run time only; the first one if there is no such number."""
    result = values[0]
    for position, value in enumerate(values[1:], 1):
        result = where(number == position, value, result)
    return result


def _on(means: tuple[Scalar, ...], values: Sequence[Scalar], share: Scalar) -> tuple[Scalar, ...]:
    return tuple(mean + share * (value - mean) for mean, value in zip(means, values, strict=True))


def _highest(scores: Sequence[Scalar], counts: Sequence[Scalar]) -> tuple[Scalar, Scalar]:
    """Number and score of the highest score among those that count; 0 and `NEVER` if none counts."""
    best: Scalar = 0.0
    top: Scalar = NEVER
    for number, (score, count) in enumerate(zip(scores, counts, strict=True)):
        better = both(count, score > top)
        best, top = where(better, float(number), best), where(better, score, top)
    return best, top


@dataclass(frozen=True)
class Testability:
    """Decide which hypotheses may be declared, and which faults would show.

    No fault is declared at standstill and in reverse, no fault of a wheel while the vehicle brakes harder than with its
    drives, none of a missing sensor, and none of a steering motor without the sensor of the torque of both motors.
    """

    # number of standard deviations of the prediction by which a fault must change a reading to show
    shows: Annotated[float, ""] = 4.0
    # time without a reading after which a sensor is missing; longer than the interval of the slowest channel
    missing: Annotated[float, "s"] = 0.2
    # factor on all limits while a sensor is missing; fault-free ratios are up to 1.7 times as large then
    poorer: Annotated[float, ""] = 1.7
    fewest: Annotated[float, ""] = 4.0  # least number of available sensors for any declaration
    # least number of sensors that a hypothesis leaves: two give speed and yaw rate, a third checks them
    remaining: Annotated[float, ""] = 2.0
    judged: tuple[str, ...] = OF_AUTOMATED  # sensors that the vehicle has
    # lateral acceleration from which no fault is declared, since tyres may slide as in no calibration drive; those of
    # the demonstrator reach 5.9 m/s**2
    cornering: Annotated[float, "m/s**2"] = 6.5
    # time for which no fault is declared afterwards, and after an axle lacked force in that bend; the filters recover
    # in it
    stays: Annotated[float, "s"] = 0.5
    # factor on the change whose first sample exceeds the limit, for a change that is seen while it lasts: filters that
    # use the sensor follow it in part, and no other hypothesis may explain it as well. Of injected changes of ten
    # seconds, nine of ten are seen (virtual cars and demonstrators of seeds 101 to 104)
    surely: Annotated[float, ""] = 2.0
    # the same for the yaw rate and the steering angle, whose offsets are states of the filters
    followed: Annotated[float, ""] = 2.5

    def multiple(self, weighing: Weighing, name: str) -> float:
        """Smallest lasting change of an element that is seen, in standard deviations of its prediction by the others.

        A change of x of them has a log-likelihood ratio of x^2 / 2 less the cost of leaving out the sensor.
        """
        number = weighing.number(name)
        assert number is not None
        cost = weighing.prices[SENSORS.index(name)] if name in SENSORS else 0.0
        factor = self.followed if name in ("yaw_rate", "steering_wheel_angle") else self.surely
        return factor * math.sqrt(2.0 * (cost + weighing.limits.fast[number - 1]))

    def cornered(self, before: Scalar, acceleration: Scalar, lacks: Scalar, sample_time: float) -> Scalar:
        """Number of samples for which tyres may still slide; without the acceleration no hard cornering is detected."""
        hard = absolute(where(present(acceleration), acceleration, 0.0)) > self.cornering
        return where(either(hard, both(before > 0.5, lacks)), self.stays / sample_time, maximum(before - 1.0, 0.0))

    def counting(self, weighing: Weighing, seen: LeaveOutFilter.Output, follows: Scalar) -> list[Scalar]:
        """Whether a sample may count for each hypothesis: only if `follows`, for wheels only without braking."""
        braked = both(follows, seen.driven)
        return [braked if {*ALL_WHEELS} & {*each.sensors} else follows for each in weighing.hypotheses]

    def open(self, weighing: Weighing, unread: Sequence[Scalar], suspected: Elements) -> tuple[list[Scalar], Scalar]:
        """Whether each hypothesis may be declared with the available sensors, and factor on all limits."""
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
        return open_, where(any_of(0.0, *newly.values()), self.poorer, 1.0)

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


@dataclass(frozen=True)
class Returning:
    """Count for how long every declared element has been consistent, and withdraw the declaration."""

    # number of standard deviations of the prediction by which a fault must change a reading to show
    shows: Annotated[float, ""] = 4.0
    # number of standard deviations within which a reading is consistent with its prediction
    agrees: Annotated[float, ""] = 4.0
    # time for which an element must be consistent, in samples in which its fault would show
    recovers: Annotated[float, "s"] = 0.3
    # weight of a sample in which only a total loss would show; the estimated effect of a fault that has ended without
    # showing may be wrong by then
    doubtful: Annotated[float, ""] = 0.1
    # time after which an element is called recovering; single readings of a noisy sensor agree by chance
    hopes: Annotated[float, "s"] = 0.1
    loss_recovered: Annotated[float, ""] = 0.15  # lost share of torque below which an actuator counts as fault-free

    def good(
        self,
        before: Elements,
        suspected: Elements,
        readings: Sequence[Scalar],
        seen: LeaveOutFilter.Output,
        effects: Tree,
    ) -> tuple[Scalar, ...]:
        """Number of samples for which each declared element has been consistent.

        A sample without a reading, or in which the fault would not show, does not count; an inconsistent one resets.
        """
        counts = []
        for place, (name, count) in enumerate(zip(ELEMENTS, before, strict=True)):
            if name in SENSORS:
                prediction, deviation = seen.prediction[place], seen.deviation[place]
                unread = negated(present(readings[place]))
                right = either(unread, absolute(readings[place] - prediction) < self.agrees * deviation)
                effect = prediction if effects is None else effects[place]
                lost = where(absolute(prediction) > self.shows * deviation, self.doubtful, 0.0)
                worth = where(unread, 0.0, where(absolute(effect) > self.shows * deviation, 1.0, lost))
            else:
                right = seen.torque_loss < maximum(self.loss_recovered, seen.loss_deviation)
                worth = where(self.shows * seen.loss_deviation < 1.0, 1.0, 0.0)
            following = where(right, count + worth, 0.0)
            counts.append(where(suspected[place], following, 0.0))
        return tuple(counts)

    def recovering(self, faulty: Elements, good: Sequence[Scalar], sample_time: float) -> Elements:
        """Flags of declared elements that have been consistent for the time `hopes`."""
        hoped = self.hopes / sample_time
        return Elements(*(both(each, count > hoped) for each, count in zip(faulty, good, strict=True)))

    def after(self, weighing: Weighing, active: Scalar, suspected: Elements, good: Sequence[Scalar]) -> Scalar:
        back = [
            both(each, count * weighing.sample_time >= self.recovers)
            for each, count in zip(suspected, good, strict=True)
        ]
        following = active
        for number, each in enumerate(weighing.hypotheses):
            for kept in ((), *((name,) for name in each.suspects if len(each.suspects) > 1)):
                target = weighing.number(*kept)
                gone = [back[ELEMENTS.index(name)] for name in each.suspects if name not in kept]
                if target is None or not gone:
                    continue
                stay = [negated(back[ELEMENTS.index(name)]) for name in kept]
                following = where(all_of(active == number, *gone, *stay), float(target), following)
        return following
