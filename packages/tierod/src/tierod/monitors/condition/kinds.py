"""Classification of a sensor's fault by kind and magnitude, from its readings and the predictions by other sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Tree
from tierod.core.graph.maths import (
    absolute,
    all_of,
    both,
    either,
    hypot,
    limit,
    log,
    maximum,
    minimum,
    negated,
    present,
    sqrt,
    where,
)
from tierod.monitors.condition.signals import SENSOR_TABLE, SENSORS
from tierod.physics.friction import share_reached

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay", "loss of torque")
"""Kinds of faults, the last one of an actuator; the number of a kind is its index here plus one, and 0 is no kind."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY, LOST_TORQUE = map(float, range(len(KINDS) + 1))
"""Numbers of the kinds, as floats for the outputs of a block."""


class Kind(NamedTuple):
    """Kind and magnitude of a fault."""

    kind: Annotated[Scalar, ""]  # number of the kind; 0 while no fault is declared
    # offset [unit of the signal], factor of a gain or an outlier, drift [unit per second], standard deviation of noise
    # [unit of the signal], delay [s]; 0 for a kind without magnitude
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]  # standard deviation of the magnitude
    # change that the fault adds to this reading, the smallest of all kinds that are likely [unit of the signal];
    # infinite if a reading that never changed changes again and is consistent
    effect: Annotated[Scalar, ""]


class Named(NamedTuple):
    """Kind, magnitude and standard deviation of the magnitude, as in `Kind`."""

    kind: Scalar
    magnitude: Scalar
    deviation: Scalar


class Fit(NamedTuple):
    """Recursive estimate of one parameter, its variance, and the log-likelihood of the readings."""

    value: Scalar
    variance: Scalar
    score: Scalar


class SlopeFit(NamedTuple):
    """Recursive estimate of start and slope, their covariance, and the log-likelihood of the readings."""

    start: Scalar
    slope: Scalar
    start_variance: Scalar
    covariance: Scalar
    slope_variance: Scalar
    score: Scalar


class KindState(NamedTuple):
    """State of the kind of one sensor's fault."""

    age: Scalar  # number of samples since the readings began to be inconsistent, with or without a reading
    seen: Scalar  # number of these with a reading
    declared_for: Scalar  # number of samples with a reading since the declaration
    last: Scalar  # last reading
    repeated: Scalar  # whether every reading since the declaration was the same
    smooth: Scalar  # recent mean of reading less prediction
    constant: Fit  # constant, offset, gain: fits of one parameter
    offset: Fit
    gain: Fit
    drift: SlopeFit  # fit of start and slope
    # weight, power, expected: sum of weights, mean squared deviation, and its expectation without a fault
    weight: Scalar
    power: Scalar
    expected: Scalar
    quick: Scalar  # mean squared deviation from the recent mean
    noise: Scalar  # log-likelihood of the readings as noise
    counted: Scalar  # counted, common: weight of the readings, and weighted sum of the log variances
    common: Scalar
    # undelayed, delays: sum of squared deviations over their variance, without delay, and with each delay
    undelayed: Scalar
    delays: tuple[Scalar, ...]
    past: tuple[Ring, ...]  # delay lines of the predictions, one for each delay
    named: Named  # kind at the last reading that supported a fault; none without evidence for one
    supports: Scalar  # whether the last reading supported a fault, see `KindOfFault.Sample`
    likeliest: Scalar  # number of the kind that is likeliest now, whose effect `Kind` gives


def selected(condition: Scalar, first: KindState, second: KindState) -> KindState:
    """One of two states, with the delay lines of the first in either case."""

    def pick(a: Tree, b: Tree) -> Tree:
        if isinstance(a, tuple):
            picked = [pick(x, y) for x, y in zip(a, b, strict=True)]
            return type(a)(*picked) if hasattr(a, "_fields") else tuple(picked)
        return where(condition, a, b)

    lines = first.past
    picked: KindState = pick(first._replace(past=()), second._replace(past=()))
    return picked._replace(past=lines)


DELAYS = (0.03, 0.05, 0.07, 0.09, 0.12, 0.15, 0.19, 0.24, 0.3, 0.37, 0.45, 0.55)
"""Delays that are compared [s], about a quarter apart: the squared deviations are a parabola between them."""

DENSE = tuple(round(0.02 * k, 2) for k in range(1, 28))
"""Delays that are compared for a signal with jumps [s]: two samples beside the true delay nothing fits any more."""

ROUGH = 60.0
"""Largest variance of the residual noise of a delay, over the variance of the prediction [-]; more than a torque with
jumps leaves one sample beside its delay. Beyond it the likelihood of the delay decreases."""
INFLUENCE = 8.0
"""Bound of a normalised deviation in the likelihood of a kind [-]: the first readings after the end of a fault must not
outweigh the evidence of seconds before it is certain that the fault has ended."""
PRICE = 5.0  # penalty of a delay against noise [nat], for one more free parameter, known to a hundredth of its range


def delays_of(jumps: bool, sample_time: float) -> tuple[int, ...]:
    """Delays that are compared for a sensor, in samples."""
    delays = DENSE if jumps else DELAYS
    return tuple(sorted({max(round(delay / sample_time), 1) for delay in delays}))


def log_density(off: Scalar, variance: Scalar, share: Scalar) -> Scalar:
    """Contribution of one reading to a log-likelihood."""
    return -0.5 * share * (minimum(off * off / variance, INFLUENCE * INFLUENCE) + log(2.0 * math.pi * variance))


def fitted(fit: Fit, reading: Scalar, row: Scalar, square: Scalar, alike: Scalar, share: Scalar) -> Fit:
    """Recursive least squares for one parameter: reading = row * parameter."""
    off, known = reading - row * fit.value, row * row * fit.variance
    gain = fit.variance * row / (known + square * alike)
    return Fit(
        fit.value + gain * off,
        maximum(fit.variance - gain * row * fit.variance, 0.0),
        fit.score + log_density(off, known + square, share),
    )


def sloped(fit: SlopeFit, off: Scalar, time: Scalar, square: Scalar, alike: Scalar, share: Scalar) -> SlopeFit:
    """Recursive least squares for start and slope of a deviation."""
    error = off - fit.start - time * fit.slope
    to_start, to_slope = fit.start_variance + time * fit.covariance, fit.covariance + time * fit.slope_variance
    known = to_start + time * to_slope
    inverse = 1.0 / (known + square * alike)
    return SlopeFit(
        fit.start + to_start * inverse * error,
        fit.slope + to_slope * inverse * error,
        maximum(fit.start_variance - to_start * inverse * to_start, 0.0),
        fit.covariance - to_start * inverse * to_slope,
        maximum(fit.slope_variance - to_slope * inverse * to_slope, 0.0),
        fit.score + log_density(error, known + square, share),
    )


def delay_of(
    state: KindState, lines: Sequence[int], step: Scalar, longer: Scalar, prediction: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Fit of a delay by a parabola through the squared deviations of the best compared delay and its neighbours.

    For a smooth signal the squared deviations grow with the square of the error of the delay, so that their minimum
    between the compared delays follows. The residual counts as noise of unknown variance, since a prediction never has
    exactly the shape of the signal.
    """
    # The best delay needs a neighbour on either side: no delay before the shortest, a mirrored one after the longest.
    misses = (state.undelayed, *state.delays, state.delays[-2])
    places = (0.0, *map(float, lines), 2.0 * lines[-1] - lines[-2])
    effects = (0.0, *(line.oldest - prediction for line in state.past), state.past[-1].oldest - prediction)
    best = [values[:3] for values in (places, misses, effects)]
    for k in range(2, len(lines) + 1):
        better = misses[k] < best[1][1]
        best = [
            tuple(where(better, new, old) for new, old in zip(values[k - 1 : k + 2], known, strict=True))
            for values, known in zip((places, misses, effects), best, strict=True)
        ]
    place, least, width = lowest(*best[:2])
    counted = maximum(state.counted, 1e-9)
    rest = least / counted
    # Profile likelihood: the unknown variance of the residual noise is replaced by its bounded estimate.
    share = limit(rest, 1.0, ROUGH)
    return (
        -0.5 * (counted * (log(share) + rest / share) + state.common) - PRICE,
        step * place,
        step * hypot(width * sqrt(share * longer), 0.5),
        between(place, *best[::2]),
    )


def lowest(places: Sequence[Scalar], values: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
    """Minimum of a parabola through three points between the outer ones, its value there, and its width."""
    left, right = places[1] - places[0], places[2] - places[1]
    down, up = (values[1] - values[0]) / left, (values[2] - values[1]) / right
    bend = maximum((up - down) / (0.5 * (left + right)), 1e-9)
    slope = (down * right + up * left) / (left + right)
    shift = limit(-slope / bend, -left, right)
    depth = values[1] + shift * (slope + 0.5 * bend * shift)
    return places[1] + shift, maximum(depth, 0.0), minimum(sqrt(2.0 / bend), places[2] - places[0])


def between(place: Scalar, places: Sequence[Scalar], values: Sequence[Scalar]) -> Scalar:
    early = (values[1] - values[0]) / (places[1] - places[0])
    late = (values[2] - values[1]) / (places[2] - places[1])
    return values[1] + (place - places[1]) * where(place < places[1], early, late)


def likeliest(options: Sequence[tuple[Scalar, ...]], doubt: Scalar) -> tuple[Scalar, ...]:
    """Number, magnitude and standard deviation of the most likely kind, and the smallest effect of all likely kinds."""
    best = options[0]
    for option in options[1:]:
        better = both(option[1], option[2] > best[2])
        best = tuple(where(better, new, old) for new, old in zip(option, best, strict=True))
    effect = best[-1]
    for option in options:
        milder = all_of(option[1], option[2] > best[2] - doubt, absolute(option[-1]) < absolute(effect))
        effect = where(milder, option[-1], effect)
    return best[0], *best[3:5], effect


NOTHING = Named(0.0, 0.0, 0.0)  # no kind
_RAMP = 2.0 * math.sqrt(3.0)  # slope of a linear ramp times its duration, over its standard deviation [-]


@dataclass(frozen=True)
class KindOfFault:
    """Compare the likelihoods of all kinds of faults of one sensor, from the first inconsistent reading on.

    That is before the declaration, since a drift is declared only after it has grown, and its beginning distinguishes
    it from an offset. While the sensor is not declared and there is no evidence for a fault, the comparison restarts
    whenever the recent mean of the deviations is consistent, or a reading jumps away from it.

    Each kind predicts the next reading with its estimates so far (Bayesian recursive least squares); the product of the
    predictive densities is its likelihood. Errors of the prediction are autocorrelated, so that a sample counts only in
    part. A reading that never changes is a loss at zero and stuck elsewhere. A large factor is called an outlier for
    the first `young` seconds, since nothing else separates an outlier from a gain.
    """

    offset: Annotated[float, ""]  # prior standard deviation of offsets [unit of the signal]
    drift: Annotated[float, ""]  # prior standard deviation of drifts [unit per second]
    rough: Annotated[float, ""]  # prior standard deviation of noise [unit of the signal]
    zero: Annotated[float, ""]  # largest magnitude of a constant reading that is a loss [unit of the signal]
    factor: Annotated[float, ""] = 1.0  # prior standard deviation of factors about one
    # prior standard deviation of a drift at its start, in standard deviations of the prediction
    start: Annotated[float, ""] = 3.0
    # time constant of the recent mean of deviations, by which an undeclared sensor is checked
    recent: Annotated[float, "s"] = 0.1
    # bound of that mean for a consistent sensor, in standard deviations; fault-free ones hardly ever exceed it
    away: Annotated[float, ""] = 2.0
    # least difference of a jump from that mean, in standard deviations, beyond half of the mean
    jumps: Annotated[float, ""] = 4.0
    # number of standard deviations by which a magnitude must differ from that of a fault-free sensor, 1 for factors and
    # 0 for all others; the decision itself errs as rarely, once in some hundred independent samples
    sure: Annotated[float, ""] = 3.0
    # least share of the squared deviations of noise that lies about the recent mean; white noise has all
    quick: Annotated[float, ""] = 0.5
    alike: Annotated[float, "s"] = 0.1  # correlation time of the prediction's errors in the likelihoods
    # correlation time of the prediction's errors in the standard deviations of magnitudes
    lasting: Annotated[float, "s"] = 0.1
    # least time for which a reading must repeat to count as constant, and of a comparison of kinds
    shortest: Annotated[float, "s"] = 0.1
    # difference in log-likelihood within which kinds are equally likely [nat]; the effect is their smallest
    doubt: Annotated[float, ""] = 6.0
    # standard deviations of the prediction within which a reading that changes again is consistent
    agrees: Annotated[float, ""] = 4.0
    # time for which a large factor is an outlier; the outliers of Li, Frey, Gauterin, section 5, last one second
    young: Annotated[float, "s"] = 1.1
    large: Annotated[float, ""] = 1.0  # least difference of a large factor from one
    # standard deviation of lasting errors of the prediction that no filter models, as of a vehicle without calibration
    # [unit of the signal]; it widens magnitudes and is no evidence of a drift
    unknown: Annotated[float, ""] = 0.0
    sample_time: Annotated[float, "s"] = 0.01  # sampling interval [s]
    delays: tuple[int, ...] = delays_of(False, 0.01)  # compared delays, in samples
    # whether no kind is named if a drift with an uncertain slope leads all other kinds by `doubt`
    withholds: bool = False

    class Sample(NamedTuple):
        """Input at one sample."""

        reading: Annotated[float, ""]  # reading of the sensor
        prediction: Annotated[float, ""]  # prediction of the reading by the other sensors
        deviation: Annotated[float, ""]  # standard deviation of reading less prediction
        declared: Annotated[float, ""]  # whether the sensor is declared faulty
        # whether it has been consistent for some time, in which case its readings are not used
        recovering: Annotated[float, ""]
        # 1 for a reading that supports a fault, 0 for another, -1 without any evidence for a fault
        supports: Annotated[float, ""]

    @classmethod
    def of_sensor(cls, name: str, sample_time: float = 0.01) -> KindOfFault:
        """Classifier for one of `SENSORS`, with prior magnitudes in proportion to its plausible range."""
        sensor = SENSOR_TABLE[SENSORS.index(name)]
        width = sensor.plausible
        expected = (0.25 * width, 0.025 * width, 0.025 * width, 1e-5 * width)
        return cls(
            *expected,
            lasting=sensor.lasting,
            sample_time=sample_time,
            delays=delays_of(sensor.jumps, sample_time),
        )

    def init(self) -> KindState:
        empty = (0.0,) * len(self.delays)
        fit = Fit(0.0, 1.0, 0.0)
        lines = tuple(Ring(delay) for delay in self.delays)
        slope = SlopeFit(*(0.0,) * 6)
        return KindState(*(0.0,) * 4, 1.0, 0.0, fit, fit, fit, slope, *(0.0,) * 8, empty, lines, NOTHING, -1.0, 0.0)

    def step(self, state: KindState, sample: Sample) -> tuple[KindState, Kind]:
        known = all_of(present(sample.reading), present(sample.prediction), present(sample.deviation))
        declared = where(present(sample.declared), sample.declared, 0.0) > 0.5
        paused = where(present(sample.recovering), sample.recovering, 0.0) > 0.5
        reading, prediction = where(known, sample.reading, 0.0), where(known, sample.prediction, 0.0)
        deviation = where(both(known, sample.deviation > 0.0), sample.deviation, 1.0)
        smooth, fault_free = self._watched(state, known, reading - prediction, deviation)
        supports = where(present(sample.supports), sample.supports, 0.0)
        # Readings that are right again before the declaration leave the comparison as it is.
        forgotten = both(fault_free, state.supports < -0.5)
        begins = either(state.seen < 0.5, both(negated(declared), either(forgotten, state.declared_for > 0.5)))
        before = selected(begins, self._fresh(state, deviation), state)
        before = before._replace(
            repeated=where(declared, before.repeated, 1.0), declared_for=where(declared, before.declared_for, 0.0)
        )
        revived = all_of(
            self._is_still(before), reading != before.last, absolute(reading - prediction) < self.agrees * deviation
        )
        counts = all_of(known, negated(paused), negated(revived), either(declared, negated(fault_free)))
        after = selected(counts, self._learnt(before, declared, reading, prediction, deviation), before)
        after = after._replace(
            age=after.age + where(after.seen > 0.5, 1.0, 0.0),
            smooth=smooth,
            last=where(both(known, either(counts, negated(declared))), reading, state.last),
            past=state.past,
        )
        best = self._named(after, prediction)
        now = Named(best.kind, best.magnitude, best.deviation)
        named = self._kept(state.named, now, after, supports)
        silent = either(negated(declared), after.declared_for < 0.5)
        effect = where(both(declared, revived), math.inf, where(silent, 0.0, best.effect))
        predicted = where(present(sample.prediction), sample.prediction, 0.0)
        # The delay lines advance once per sample, whichever state was selected above.
        after = after._replace(past=tuple(line.push(predicted) for line in state.past), named=named, supports=supports)
        after = after._replace(likeliest=best.kind)
        kind, size, off = (
            where(silent, 0.0, where(named.kind > 0.5, kept, new)) for kept, new in zip(named, now, strict=True)
        )
        return after, Kind(kind, size, off, effect)

    def _kept(self, before: Named, now: Named, state: KindState, supports: Scalar) -> Named:
        """Kind at the last reading that supported a fault: readings after its end, until it recovers, name no kind.

        The first readings after an onset are too few to name one.
        """
        taken = both(supports > 0.5, state.seen * self.sample_time >= self.shortest)
        return Named(
            *(where(taken, new, where(supports < -0.5, 0.0, old)) for old, new in zip(before, now, strict=True))
        )

    def _watched(self, state: KindState, known: Scalar, off: Scalar, deviation: Scalar) -> tuple[Scalar, Scalar]:
        """Recent mean of deviations, and whether a fault, if there is one, begins only after this sample."""
        share = share_reached(self.sample_time / self.recent)
        smooth = where(known, state.smooth + share * (off - state.smooth), state.smooth)
        within = absolute(smooth) < self.away * deviation
        jumps = absolute(off - state.smooth) > 0.5 * absolute(state.smooth) + self.jumps * deviation
        return smooth, both(known, either(within, jumps))

    def _is_still(self, state: KindState) -> Scalar:
        """Whether all readings since the declaration are equal, for `shortest` at least."""
        return both(state.repeated, state.declared_for * self.sample_time >= self.shortest)

    # -- learning ------------------------------------------------------------------------------------------------

    def _fresh(self, state: KindState, deviation: Scalar) -> KindState:
        wide = self.offset * self.offset
        start = self.start * deviation
        drift = SlopeFit(0.0, 0.0, start * start, 0.0, self.drift * self.drift, 0.0)
        return self.init()._replace(
            constant=Fit(0.0, 4.0 * wide, 0.0),
            offset=Fit(0.0, wide, 0.0),
            gain=Fit(1.0, self.factor * self.factor, 0.0),
            drift=drift,
            last=state.last,
            smooth=state.smooth,
            past=state.past,
            named=state.named,
            supports=state.supports,
            likeliest=state.likeliest,
        )

    def _learnt(
        self, before: KindState, declared: Scalar, reading: Scalar, prediction: Scalar, deviation: Scalar
    ) -> KindState:
        off, square = reading - prediction, deviation * deviation
        spread = square + maximum(before.power - before.expected, 0.0)
        worth = 1.0 / (square + self.rough * self.rough)
        weight = before.weight + worth
        share = worth / weight
        away = off - before.smooth
        first = before.seen < 0.5
        alike = self.alike / self.sample_time
        # Errors of the prediction are autocorrelated: after the first reading, `alike` samples count as one.
        counts = where(first, 1.0, 1.0 / alike)
        inverse = counts / square
        late = [reading - line.oldest for line in before.past]
        # A gain also multiplies the error of the prediction.
        rough = square * maximum(before.gain.value**2, 1.0)
        return before._replace(
            seen=before.seen + 1.0,
            declared_for=before.declared_for + where(declared, 1.0, 0.0),
            repeated=where(either(before.declared_for < 0.5, reading == before.last), before.repeated, 0.0),
            constant=fitted(before.constant, reading, 1.0, square, alike, counts),
            offset=fitted(before.offset, off, 1.0, square, alike, counts),
            gain=fitted(before.gain, reading, prediction, rough, alike, counts),
            drift=sloped(before.drift, off, before.age * self.sample_time, square, alike, counts),
            weight=weight,
            power=before.power + share * (off * off - before.power),
            expected=before.expected + share * (square - before.expected),
            quick=before.quick + share * (away * away - before.quick),
            noise=before.noise + log_density(off, where(first, self.offset * self.offset, spread), counts),
            counted=before.counted + counts,
            common=before.common + counts * log(2.0 * math.pi * square),
            undelayed=before.undelayed + inverse * (off * off),
            delays=tuple(total + inverse * (x * x) for total, x in zip(before.delays, late, strict=True)),
        )

    # -- naming --------------------------------------------------------------------------------------------------

    def _named(self, state: KindState, prediction: Scalar) -> Kind:
        young = both(absolute(state.gain.value - 1.0) > self.large, state.declared_for * self.sample_time < self.young)
        noise = sqrt(maximum(state.power - state.expected, 0.0))
        rough = state.power / sqrt(maximum(2.0 * state.seen * (state.power - state.expected), 1e-9))
        misjudged = self.unknown * self.unknown / (2.0 * maximum(noise, self.zero))
        rough = sqrt(rough * rough + misjudged * misjudged)
        # Lasting errors of the prediction may form a ramp over the whole age, whose slope a certain drift must exceed.
        wrong = _RAMP * self.unknown / maximum(state.age * self.sample_time, self.sample_time)
        moves = absolute(state.drift.slope) > self.sure * sqrt(state.drift.slope_variance + wrong * wrong)
        drifted = state.drift.start + state.drift.slope * state.age * self.sample_time
        longer = self.lasting / self.alike
        likely, late, unsure, behind = delay_of(state, self.delays, self.sample_time, longer, prediction)
        offset, gain = (each._replace(variance=longer * each.variance) for each in (state.offset, state.gain))
        square = self.unknown * self.unknown
        constant_off = sqrt(offset.variance + square)
        # Both variances come from the same readings: their ratio shows how large the predictions are.
        factor_off = sqrt(gain.variance * (1.0 + square / maximum(offset.variance, self.zero * self.zero)))
        slope_off = sqrt(longer * state.drift.slope_variance + wrong * wrong)
        # Noise that the fault-free deviation explains is none.
        noisy = both(state.quick > self.quick * state.power, state.power > 2.0 * state.expected)
        factor = where(young, OUTLIER, GAIN)
        drift: tuple[Scalar, ...] = (DRIFT, moves, state.drift.score, state.drift.slope, slope_off, drifted)
        if self.withholds:
            kind, slope, off = (where(moves, each, 0.0) for each in (DRIFT, state.drift.slope, slope_off))
            drift = (kind, 1.0, state.drift.score - where(moves, 0.0, self.doubt), slope, off, drifted)
        options: tuple[tuple[Scalar, ...], ...] = (
            (STUCK, 1.0, state.constant.score, 0.0, 0.0, state.constant.value - prediction),
            (OFFSET, 1.0, offset.score, offset.value, constant_off, offset.value),
            (factor, 1.0, gain.score, gain.value, factor_off, (gain.value - 1.0) * prediction),
            drift,
            (NOISE, noisy, state.noise, noise, rough, noise),
            (DELAY, late > self.sure * unsure, likely, late, unsure, behind),
        )
        best = self._sure(*likeliest(options, self.doubt))
        still = self._is_still(state)
        where_it_stays = state.constant.value
        constant = (where(absolute(where_it_stays) < self.zero, LOSS, STUCK), 0.0, 0.0, where_it_stays - prediction)
        return Kind(*(where(still, a, b) for a, b in zip(constant, best, strict=True)))

    def _sure(self, kind: Scalar, magnitude: Scalar, deviation: Scalar, effect: Scalar) -> tuple[Scalar, ...]:
        """Likeliest kind, or none where the interval of its magnitude contains that of a fault-free sensor."""
        neutral = where(either(kind == GAIN, kind == OUTLIER), 1.0, 0.0)
        sure = either(kind == STUCK, absolute(magnitude - neutral) > self.sure * deviation)
        return *(where(sure, each, 0.0) for each in (kind, magnitude, deviation)), effect
