"""Kind of a sensor's fault, and its magnitude: its readings against those that the other sensors predict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar
from tierod.core.graph.maths import absolute, all_of, both, either, log, maximum, negated, present, sqrt, where
from tierod.monitors.condition.kinds.catalogue import (
    DELAY,
    DRIFT,
    GAIN,
    LOSS,
    NOISE,
    OFFSET,
    OUTLIER,
    STUCK,
    Fit,
    Kind,
    KindState,
    SlopeFit,
    selected,
)
from tierod.monitors.condition.kinds.fits import delay_of, delays_of, fitted, likeliest, log_density, sloped
from tierod.monitors.condition.signals import SENSOR_TABLE, SENSORS
from tierod.physics.lag import share_reached

_RAMP = 2.0 * math.sqrt(3.0)
"""Slope of an error that grows evenly over a while, times that while, over its root mean square."""


@dataclass(frozen=True)
class KindOfFault:
    """Weigh the kinds of faults of one sensor against each other, from where its readings began to be off.

    That is before its declaration: a drift is declared when it has grown, and what it grew from makes it differ from an
    offset. While a sensor that is not declared is as it should on a recent mean, or jumps off, all begins anew.

    Each kind predicts the next reading with what it has learnt so far (recursive least squares in the Bayesian sense);
    the product of those densities is its likelihood. Errors of the prediction last for a while, so that a sample counts
    for a part of one only. A reading that never changes is a loss at zero and stuck elsewhere; a large factor is an
    outlier while it is young, since nothing else separates them.

    Args:
        offset: expected magnitude of offsets, standard deviation [unit of the signal]
        drift: likewise, of drifts [unit per second]
        rough: likewise, of noise [unit of the signal]
        zero: below which a reading that never changes is a loss [unit of the signal]
        factor: expected magnitude of factors about one
        start: of a drift where it begins to be off, in deviations of the prediction: a drift starts at zero
        recent: over which the mean of deviations is taken that shows whether a sensor is as it should
        away: deviations of the prediction beyond which that mean is off; that of fault-free ones hardly ever is
        jumps: deviations beyond half of that mean by which a reading must differ from it to be the first one of a jump
        sure: deviations by which the slope of a drift, or a delay, differs from none
        quick: share of the squared deviations that noise has about its own recent mean at least; all of white noise
        alike: over which errors of the prediction are alike, in the weighing of kinds
        lasting: over which they are alike in what a magnitude is uncertain by
        shortest: for which a reading must repeat itself
        doubt: nats within which a kind may be as well as the likeliest: the effect is the mildest of theirs
        agrees: deviations of the prediction within which a reading that moves again is as it should be
        young: until which a large factor is an outlier; Li, Frey, Gauterin, section 5, have outliers of one second
        large: difference of a large factor from one
        unknown: standard deviation of lasting errors of predictions that no filter models, as of a vehicle that
            was not calibrated: it widens magnitudes, and passes for no drift [unit of the signal]
        sample_time: [s]
        delays: that are compared, in samples
        withholds: whether no kind is named where a drift whose slope is not sure is likelier than all others by `doubt`
    """

    offset: Annotated[float, ""]
    drift: Annotated[float, ""]
    rough: Annotated[float, ""]
    zero: Annotated[float, ""]
    factor: Annotated[float, ""] = 1.0
    start: Annotated[float, ""] = 3.0
    recent: Annotated[float, "s"] = 0.1
    away: Annotated[float, ""] = 2.0
    jumps: Annotated[float, ""] = 4.0
    sure: Annotated[float, ""] = 3.0
    quick: Annotated[float, ""] = 0.5
    alike: Annotated[float, "s"] = 0.1
    lasting: Annotated[float, "s"] = 0.1
    shortest: Annotated[float, "s"] = 0.1
    doubt: Annotated[float, ""] = 6.0
    agrees: Annotated[float, ""] = 4.0
    young: Annotated[float, "s"] = 1.1
    large: Annotated[float, ""] = 1.0
    unknown: Annotated[float, ""] = 0.0
    sample_time: Annotated[float, "s"] = 0.01
    delays: tuple[int, ...] = delays_of(False, 0.01)
    withholds: bool = False

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
    def of_sensor(cls, name: str, sample_time: float = 0.01) -> KindOfFault:
        """For one of `SENSORS`, expecting magnitudes in proportion to its plausible range."""
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
        """Nothing declared."""
        empty = (0.0,) * len(self.delays)
        fit = Fit(0.0, 1.0, 0.0)
        lines = tuple(Ring(delay) for delay in self.delays)
        slope = SlopeFit(*(0.0,) * 6)
        return KindState(*(0.0,) * 4, 1.0, 0.0, fit, fit, fit, slope, *(0.0,) * 8, empty, lines)

    def step(self, state: KindState, sample: Sample) -> tuple[KindState, Kind]:
        """One sample on."""
        known = all_of(present(sample.reading), present(sample.prediction), present(sample.deviation))
        declared = where(present(sample.declared), sample.declared, 0.0) > 0.5
        paused = where(present(sample.recovering), sample.recovering, 0.0) > 0.5
        reading, prediction = where(known, sample.reading, 0.0), where(known, sample.prediction, 0.0)
        deviation = where(both(known, sample.deviation > 0.0), sample.deviation, 1.0)
        smooth, fault_free = self._watched(state, known, reading - prediction, deviation)
        begins = either(state.seen < 0.5, both(negated(declared), either(fault_free, state.declared_for > 0.5)))
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
        named = self._named(after, prediction, either(negated(declared), after.declared_for < 0.5))
        named = named._replace(effect=where(both(declared, revived), math.inf, named.effect))
        predicted = where(present(sample.prediction), sample.prediction, 0.0)
        return after._replace(past=tuple(line.push(predicted) for line in state.past)), named

    def _watched(self, state: KindState, known: Scalar, off: Scalar, deviation: Scalar) -> tuple[Scalar, Scalar]:
        """The recent mean of deviations, and whether a fault, if any, begins after this sample."""
        share = share_reached(self.sample_time / self.recent)
        smooth = where(known, state.smooth + share * (off - state.smooth), state.smooth)
        within = absolute(smooth) < self.away * deviation
        jumps = absolute(off - state.smooth) > 0.5 * absolute(state.smooth) + self.jumps * deviation
        return smooth, both(known, either(within, jumps))

    def _is_still(self, state: KindState) -> Scalar:
        """Whether no reading since the declaration differed from the others."""
        return both(state.repeated, state.declared_for * self.sample_time >= self.shortest)

    # -- learning ------------------------------------------------------------------------------------------------

    def _fresh(self, state: KindState, deviation: Scalar) -> KindState:
        """Before the first reading that is off."""
        wide = self.offset * self.offset
        start = self.start * deviation
        drift = SlopeFit(0.0, 0.0, start * start, 0.0, self.drift * self.drift, 0.0)
        return state._replace(
            age=0.0,
            seen=0.0,
            declared_for=0.0,
            repeated=1.0,
            constant=Fit(0.0, 4.0 * wide, 0.0),
            offset=Fit(0.0, wide, 0.0),
            gain=Fit(1.0, self.factor * self.factor, 0.0),
            drift=drift,
            weight=0.0,
            power=0.0,
            expected=0.0,
            quick=0.0,
            noise=0.0,
            counted=0.0,
            common=0.0,
            undelayed=0.0,
            delays=(0.0,) * len(self.delays),
        )

    def _learnt(
        self, before: KindState, declared: Scalar, reading: Scalar, prediction: Scalar, deviation: Scalar
    ) -> KindState:
        """After one reading."""
        off, square = reading - prediction, deviation * deviation
        spread = square + maximum(before.power - before.expected, 0.0)
        worth = 1.0 / (square + self.rough * self.rough)
        weight = before.weight + worth
        share = worth / weight
        away = off - before.smooth
        first = before.seen < 0.5
        alike = self.alike / self.sample_time
        counts = where(first, 1.0, 1.0 / alike)
        inverse = counts / square
        late = [reading - line.oldest for line in before.past]
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

    def _named(self, state: KindState, prediction: Scalar, silent: Scalar) -> Kind:
        """The likeliest kind and its magnitude."""
        young = both(absolute(state.gain.value - 1.0) > self.large, state.declared_for * self.sample_time < self.young)
        noise = sqrt(maximum(state.power - state.expected, 0.0))
        rough = state.power / sqrt(maximum(2.0 * state.seen * (state.power - state.expected), 1e-9))
        misjudged = self.unknown * self.unknown / (2.0 * maximum(noise, self.zero))
        rough = sqrt(rough * rough + misjudged * misjudged)
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
        noisy = state.quick > self.quick * state.power
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
        best = likeliest(options, self.doubt)
        still = self._is_still(state)
        where_it_stays = state.constant.value
        constant = (where(absolute(where_it_stays) < self.zero, LOSS, STUCK), 0.0, 0.0, where_it_stays - prediction)
        named = (where(still, a, b) for a, b in zip(constant, best, strict=True))
        return Kind(*(where(silent, 0.0, value) for value in named))
