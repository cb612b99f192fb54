"""What kind of fault a sensor has, and how large: its readings against what the other sensors say they should be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.block import Ring
from tierod.graph.maths import absolute, all_of, both, either, log, maximum, negated, present, sqrt, where
from tierod.monitors.condition.kind_state import Fit, KindState, SlopeFit, parabola, parts, selected
from tierod.monitors.condition.signals import SENSORS
from tierod.monitors.condition.tuning import PlausibleRange

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay")
"""Kinds of faults of a sensor; the number of a kind is its place here plus one, 0 stands for none."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY = (float(number) for number in range(9))

NEVER = -1e9
"""Score of a kind that cannot be: far below any logarithm of likelihood."""

DELAYS = (0.04, 0.06, 0.08, 0.11, 0.15, 0.2, 0.26, 0.34, 0.45)
"""Delays that are compared [s]: each some third longer than the one before, so that a parabola lies well between."""


LASTING = {"yaw_rate": 0.3, "steering_wheel_angle": 2.0}
"""Errors of what the others foretell of a sensor are alike for so long [s]; by the variance of their means over ten
seconds, on healthy drives of two virtual demonstrators: 0.2 and 0.35 s, 1.8 and 2.0 s, 0.05 s at most of all others."""


class Kind(NamedTuple):
    """The kind of a fault.

    Args:
        kind: number of the kind; 0 while nothing is declared
        size: of an offset in the unit of the signal, of a gain or an outlier the factor, of a drift per second, of
            noise its standard deviation, of a delay in seconds; 0 of what has none
        deviation: standard deviation of the size
        effect: what the fault adds to this reading [unit of the signal]; infinite where a reading that never changed
            moves again, and as it should
    """

    kind: Annotated[float, ""]
    size: Annotated[float, ""]
    deviation: Annotated[float, ""]
    effect: Annotated[float, ""]


@dataclass(frozen=True)
class KindOfFault:
    """Weigh the kinds of faults of one sensor against each other from its declaration on.

    Each kind predicts the next reading with what it has learnt so far (recursive least squares in the Bayesian sense);
    the product of those densities is its likelihood. Errors of the prediction last for a while, so that a sample counts
    for a part of one only. A reading that never changes is a loss at zero and stuck elsewhere; a large factor is an
    outlier while it is young, since nothing else tells them apart.

    Args:
        offset: expected size of offsets, standard deviation [unit of the signal]
        drift: likewise, of drifts [unit per second]
        rough: likewise, of noise [unit of the signal]
        zero: below which a reading that never changes is a loss [unit of the signal]
        factor: expected size of factors about one
        start: of a drift when it is declared, in deviations of the prediction
        sure: deviations by which the slope of a drift differs from none
        alike: over which errors of the prediction are alike, in the weighing of kinds
        lasting: over which they are alike in what a size is uncertain by, see `LASTING`
        shortest: for which a reading must repeat itself
        agrees: deviations of the prediction within which a reading that moves again is as it should be
        young: until which a large factor is an outlier; Li, Frey, Gauterin, section 5, have outliers of one second
        large: what a large factor differs from one by
        unknown: standard deviation of what predictions are off by that no filter knows of, as of a vehicle that nobody
            has calibrated [unit of the signal]
        sample_time: [s]
    """

    offset: Annotated[float, ""]
    drift: Annotated[float, ""]
    rough: Annotated[float, ""]
    zero: Annotated[float, ""]
    factor: Annotated[float, ""] = 1.0
    start: Annotated[float, ""] = 6.0
    sure: Annotated[float, ""] = 3.0
    alike: Annotated[float, "s"] = 0.1
    lasting: Annotated[float, "s"] = 0.1
    shortest: Annotated[float, "s"] = 0.1
    agrees: Annotated[float, ""] = 4.0
    young: Annotated[float, "s"] = 1.1
    large: Annotated[float, ""] = 1.0
    unknown: Annotated[float, ""] = 0.0
    sample_time: Annotated[float, "s"] = 0.01
    delays: tuple[int, ...] = tuple(round(delay / 0.01) for delay in DELAYS)

    class Sample(NamedTuple):
        """One reading.

        Args:
            reading: of the sensor
            prediction: of the reading, from all others
            deviation: standard deviation of reading less prediction
            declared: whether the sensor is declared faulty
            recovering: whether it has been as it should for a while: nothing is learnt from such readings
        """

        reading: Annotated[float, ""]
        prediction: Annotated[float, ""]
        deviation: Annotated[float, ""]
        declared: Annotated[float, ""]
        recovering: Annotated[float, ""]

    @classmethod
    def of_sensor(cls, name: str, plausible: PlausibleRange, sample_time: float = 0.01) -> KindOfFault:
        """For one of `SENSORS`, expecting sizes in proportion to its plausible range."""
        widths = (
            *(plausible.wheel_speed, plausible.wheel_speed, plausible.yaw_rate, plausible.steering_wheel_angle),
            *(plausible.steering_shaft_torque, plausible.tie_rod_force),
        )
        width = widths[SENSORS.index(name)]
        lines = tuple(max(round(delay / sample_time), 1) for delay in DELAYS)
        expected = (0.25 * width, 0.025 * width, 0.025 * width, 1e-5 * width)
        return cls(*expected, lasting=LASTING.get(name, cls.lasting), sample_time=sample_time, delays=lines)

    def init(self) -> KindState:
        """Nothing declared."""
        empty = (0.0,) * len(self.delays)
        fit = Fit(0.0, 1.0, 0.0)
        lines = tuple(Ring(size) for size in self.delays)
        return KindState(0.0, 0.0, 1.0, fit, fit, fit, SlopeFit(*(0.0,) * 6), 0.0, 0.0, 0.0, 0.0, empty, lines)

    def step(self, state: KindState, sample: Any) -> tuple[KindState, Kind]:
        """One sample on."""
        known = all_of(present(sample.reading), present(sample.prediction), present(sample.deviation))
        declared = where(present(sample.declared), sample.declared, 0.0) > 0.5
        paused = where(present(sample.recovering), sample.recovering, 0.0) > 0.5
        counts, dropped = all_of(known, declared, negated(paused)), negated(declared)
        reading, prediction = where(known, sample.reading, 0.0), where(known, sample.prediction, 0.0)
        deviation = where(both(known, sample.deviation > 0.0), sample.deviation, 1.0)
        deviation = sqrt(deviation * deviation + self.unknown * self.unknown)
        fresh = self._fresh(state, deviation)
        before = selected(either(dropped, state.seen < 0.5), fresh, state)
        learnt = self._learnt(before, reading, prediction, deviation)
        revived = all_of(
            self._is_still(before), reading != before.last, absolute(reading - prediction) < self.agrees * deviation
        )
        counts = both(counts, negated(revived))
        after = selected(counts, learnt, before)
        after = after._replace(last=where(both(known, either(counts, dropped)), reading, state.last), past=state.past)
        named = self._named(after, prediction, dropped)
        named = named._replace(effect=where(both(declared, revived), math.inf, named.effect))
        foretold = where(present(sample.prediction), sample.prediction, 0.0)
        return after._replace(past=tuple(line.push(foretold) for line in state.past)), named

    def _is_still(self, state: KindState) -> Any:
        """Whether no reading since the declaration differed from the others."""
        return both(state.repeated, state.seen * self.sample_time >= self.shortest)

    # -- learning ------------------------------------------------------------------------------------------------

    def _fresh(self, state: KindState, deviation: Any) -> KindState:
        """Before the first reading after a declaration."""
        wide = self.offset * self.offset
        start = self.start * deviation
        drift = SlopeFit(0.0, 0.0, start * start, 0.0, self.drift * self.drift, 0.0)
        return state._replace(
            seen=0.0,
            repeated=1.0,
            constant=Fit(0.0, 4.0 * wide, 0.0),
            offset=Fit(0.0, wide, 0.0),
            gain=Fit(1.0, self.factor * self.factor, 0.0),
            drift=drift,
            weight=0.0,
            power=0.0,
            expected=0.0,
            noise=0.0,
            delays=(0.0,) * len(self.delays),
        )

    def _learnt(self, before: KindState, reading: Any, prediction: Any, deviation: Any) -> KindState:
        """After one reading."""
        off, square = reading - prediction, deviation * deviation
        time = before.seen * self.sample_time
        spread = square + maximum(before.power - before.expected, 0.0)
        worth = 1.0 / (square + self.rough * self.rough)
        weight = before.weight + worth
        share = worth / weight
        first = before.seen < 0.5
        return before._replace(
            seen=before.seen + 1.0,
            repeated=where(either(first, reading == before.last), before.repeated, 0.0),
            constant=self._fitted(before.constant, reading, 1.0, square, first),
            offset=self._fitted(before.offset, off, 1.0, square, first),
            gain=self._fitted(before.gain, reading, prediction, square * maximum(before.gain.value**2, 1.0), first),
            drift=self._sloped(before.drift, off, time, square, first),
            weight=weight,
            power=before.power + share * (off * off - before.power),
            expected=before.expected + share * (square - before.expected),
            noise=before.noise + self._density(off, where(first, self.offset * self.offset, spread), first),
            delays=tuple(
                score + self._density(reading - line.oldest, square, first)
                for score, line in zip(before.delays, before.past, strict=True)
            ),
        )

    def _density(self, off: Any, variance: Any, first: Any) -> Any:
        """What one reading adds to a logarithm of likelihood; the first one counts whole."""
        share = where(first, 1.0, self.sample_time / self.alike)
        return -0.5 * share * (off * off / variance + log(2.0 * math.pi * variance))

    def _fitted(self, fit: Fit, reading: Any, row: Any, square: Any, first: Any) -> Fit:
        """One parameter, one reading on: reading = row * parameter."""
        off, known = reading - row * fit.value, row * row * fit.variance
        gain = fit.variance * row / (known + square * (self.alike / self.sample_time))
        return Fit(
            fit.value + gain * off,
            maximum(fit.variance - gain * row * fit.variance, 0.0),
            fit.score + self._density(off, known + square, first),
        )

    def _sloped(self, fit: SlopeFit, off: Any, time: Any, square: Any, first: Any) -> SlopeFit:
        """Start and slope, one deviation on."""
        error = off - fit.start - time * fit.slope
        to_start, to_slope = fit.start_variance + time * fit.covariance, fit.covariance + time * fit.slope_variance
        known = to_start + time * to_slope
        inverse = 1.0 / (known + square * (self.alike / self.sample_time))
        return SlopeFit(
            fit.start + to_start * inverse * error,
            fit.slope + to_slope * inverse * error,
            maximum(fit.start_variance - to_start * inverse * to_start, 0.0),
            fit.covariance - to_start * inverse * to_slope,
            maximum(fit.slope_variance - to_slope * inverse * to_slope, 0.0),
            fit.score + self._density(error, known + square, first),
        )

    # -- naming --------------------------------------------------------------------------------------------------

    def _named(self, state: KindState, prediction: Any, dropped: Any) -> Kind:
        """The likeliest kind and its size."""
        young = both(absolute(state.gain.value - 1.0) > self.large, state.seen * self.sample_time < self.young)
        noise = sqrt(maximum(state.power - state.expected, 0.0))
        rough = state.power / sqrt(maximum(2.0 * state.seen * (state.power - state.expected), 1e-9))
        misjudged = self.unknown * self.unknown / (2.0 * maximum(noise, self.zero))
        rough = sqrt(rough * rough + misjudged * misjudged)
        uncertain = sqrt(state.drift.slope_variance)
        moves = absolute(state.drift.slope) > self.sure * uncertain
        drifted = state.drift.start + state.drift.slope * state.seen * self.sample_time
        longer = self.lasting / self.alike
        offset, gain = (each._replace(variance=longer * each.variance) for each in (state.offset, state.gain))
        options = (
            (STUCK, state.constant.score, 0.0, 0.0, state.constant.value - prediction),
            (OFFSET, *parts(offset), offset.value),
            (where(young, OUTLIER, GAIN), *parts(gain), (gain.value - 1.0) * prediction),
            (DRIFT, where(moves, state.drift.score, NEVER), state.drift.slope, sqrt(longer) * uncertain, drifted),
            (NOISE, state.noise, noise, rough, noise),
            (DELAY, *self._delay(state, prediction)),
        )
        best = options[0]
        for option in options[1:]:
            better = option[1] > best[1]
            best = tuple(where(better, new, old) for new, old in zip(option, best, strict=True))
        still = self._is_still(state)
        where_it_stays = state.constant.value
        constant = (where(absolute(where_it_stays) < self.zero, LOSS, STUCK), 0.0, 0.0, where_it_stays - prediction)
        named = (where(still, a, b) for a, b in zip(constant, (best[0], *best[2:]), strict=True))
        silent = either(dropped, state.seen < 0.5)
        return Kind(*(where(silent, 0.0, value) for value in named))

    def _delay(self, state: KindState, prediction: Any) -> tuple[Any, Any, Any, Any]:
        """Score, delay, standard deviation and effect: a parabola through the best of those compared."""
        times, scores = [size * self.sample_time for size in self.delays], state.delays
        effects = [line.oldest - prediction for line in state.past]
        top, best, width, effect = scores[0], times[0], times[0], effects[0]
        for k in range(1, len(times)):
            better = scores[k] > top
            if k + 1 < len(times):
                peak, sharp = parabola(times[k - 1 : k + 2], scores[k - 1 : k + 2])
            else:
                peak, sharp = times[k], times[k] - times[k - 1]
            best, width = where(better, peak, best), where(better, sharp, width)
            top, effect = where(better, scores[k], top), where(better, effects[k], effect)
        return top, best, width, effect
