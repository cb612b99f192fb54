"""Hypotheses weighed against the active one: limited log-likelihood ratios, smoothed fast and slowly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import all_of, any_of, both, either, greatest_of, maximum, minimum, negated, where
from tierod.monitors.condition.hypotheses import Hypothesis
from tierod.monitors.condition.signals import SENSORS
from tierod.physics.lag import share_reached

NEVER = -1e9
"""Score of what cannot be chosen: far below any ratio."""


@dataclass(frozen=True)
class Limits:
    """Limits between hypotheses; all of them come from calibration on fault-free drives.

    Args:
        fast, slow: mean log-likelihood ratio against the active hypothesis, over the short and the long time, that only
            a fault exceeds; per hypothesis but healthy, in their order, above 0, so that a missing reading never does
        gap: by which the best hypothesis leads all that do not contain it, nor are contained
        margin: by which two suspects must explain more than one
    """

    fast: tuple[Annotated[float, ""], ...]
    slow: tuple[Annotated[float, ""], ...]
    gap: Annotated[float, ""]
    margin: Annotated[float, ""]


class Weights(NamedTuple):
    """Smoothed log-likelihood ratios of all hypotheses against the active one, per sample."""

    fast: tuple[Scalar, ...]
    slow: tuple[Scalar, ...]


class Ranking(NamedTuple):
    """The outcome of one sample.

    Args:
        exceeding: whether any other hypothesis is beyond its limit
        best: the number of the best of those
        lead: score of the best less that of the best rival; 0 while a rival would explain all other sensors better
        rivals: per hypothesis, whether it might as well be the one
    """

    exceeding: Scalar
    best: Scalar
    lead: Scalar
    rivals: tuple[Scalar, ...]


@dataclass(frozen=True)
class Weighing:
    """Ratios and ranks of the hypotheses of a bank.

    Args:
        hypotheses: in the order of the lanes, healthy first
        limits: from calibration
        sample_time: [s]
        fast_time, slow_time: constants of both exponential means
        largest: by which one sample may count for one hypothesis against another, so that a single reading far off
            declares nothing; some three times the price of leaving out a sensor
        prices: of every sensor, what leaving it out costs per sample where nothing is at fault; see `tuning.prices`

    An error that grows slowly bends the estimates of everything else, at little cost per sample, while leaving out
    the sensor that errs costs its whole price; a cheaper one then leads. Hence the best must lead without prices too.
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
                    f"{given} {name} limits came for {len(self.hypotheses) - 1} hypotheses beside the healthy one; "
                    "give one for each, in their order"
                )

    def init(self) -> Weights:
        """All alike."""
        zeros = (0.0,) * len(self.hypotheses)
        return Weights(zeros, zeros)

    def smoothed(
        self, weights: Weights, likelihoods: Sequence[Scalar], active: Scalar, counting: Sequence[Scalar] | None = None
    ) -> Weights:
        """One sample on.

        Args:
            weights: after the sample before
            likelihoods: logarithm of each hypothesis' density of this sample
            active: the number of the hypothesis that holds
            counting: whether the sample may count for each hypothesis; for all if None
        """
        best = greatest_of(*likelihoods)
        limited = [maximum(value, best - self.largest) for value in likelihoods]
        own = chosen(limited, active)
        ratios = [value - own for value in limited]
        if counting is not None:
            ratios = [where(counts, ratio, minimum(ratio, 0.0)) for counts, ratio in zip(counting, ratios, strict=True)]
        shares = [share_reached(self.sample_time / time) for time in (self.fast_time, self.slow_time)]
        return Weights(*(_on(mean, ratios, share) for mean, share in zip(weights, shares, strict=True)))

    def restarted(self, weights: Weights, active: Scalar, changed: Scalar) -> Weights:
        """Weights where another hypothesis holds from now on: evidence for any other one is discarded.

        What was against one that leaves out a sensor stays, over the long time: its price is paid on. Without it a bump
        that comes just then would do for a second fault.

        Args:
            weights: after this sample, against the hypothesis that held
            active: the number of the hypothesis that holds now
            changed: whether it is another one
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
        """The hypothesis that explains the samples better than the active one, and the best one.

        Args:
            weights: after this sample
            active: the number of the hypothesis that holds
            widening: factor of all limits
            observable: whether each hypothesis may be declared with the readings that there are; all may if None
        """
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
        """The number of the hypothesis that suspects exactly these; None if there is none."""
        for number, each in enumerate(self.hypotheses):
            if set(each.suspects) == set(suspects):
                return number
        return None

    def naming(self, element: str) -> list[int]:
        """The numbers of the hypotheses that suspect an element, alone or beside others."""
        return [number for number, each in enumerate(self.hypotheses) if element in each.suspects]

    def _is_new(self, number: int, holds: Sequence[Scalar]) -> Scalar:
        """Whether a hypothesis may follow the active one: it suspects all its sensors, and something else.

        A lost sensor whose true value is near zero agrees with hypotheses that use it, which shows nothing; a wrong
        one recovers once the right one is suspected beside it.
        """
        own = self.hypotheses[number]
        before = [
            holds[k]
            for k, each in enumerate(self.hypotheses)
            if {*each.sensors} <= {*own.suspects} and not ({*own.suspects} <= {*each.suspects} and own.agrees(each))
        ]
        return any_of(0.0, *before)

    def _exclusion_credit(self, hypothesis: Hypothesis, holds: Sequence[Scalar]) -> Scalar:
        """The price of the sensor that a hypothesis leaves out beside the active one; none for two at once."""
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
        """Whether a hypothesis is beyond its limit: of two suspects, one active, that of the other alone."""
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
        """Hypotheses that contain this one or are contained, healthy left out.

        Of two actuators that lose the same share one alone is no part: it stays a rival of both. Both are none of one,
        which explains all with less.
        """
        own = self.hypotheses[number]
        return [
            k
            for k, each in enumerate(self.hypotheses)
            if k and ((own.agrees(each) and {*own.suspects} <= {*each.suspects}) or {*own.suspects} >= {*each.suspects})
        ]


def chosen(values: Sequence[Scalar], number: Scalar) -> Scalar:
    """One of several values, by a number that is known at run time only; the first where there is no such."""
    result = values[0]
    for position, value in enumerate(values[1:], 1):
        result = where(number == position, value, result)
    return result


def _on(means: tuple[Scalar, ...], values: Sequence[Scalar], share: Scalar) -> tuple[Scalar, ...]:
    return tuple(mean + share * (value - mean) for mean, value in zip(means, values, strict=True))


def _highest(scores: Sequence[Scalar], counts: Sequence[Scalar]) -> tuple[Scalar, Scalar]:
    """Number and score of the highest among those that count; 0 and `NEVER` if none does."""
    best: Scalar = 0.0
    top: Scalar = NEVER
    for number, (score, count) in enumerate(zip(scores, counts, strict=True)):
        better = both(count, score > top)
        best, top = where(better, float(number), best), where(better, score, top)
    return best, top
