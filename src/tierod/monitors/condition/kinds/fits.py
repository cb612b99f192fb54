"""Fit of a faulty sensor's readings by an offset, a factor, a slope, a delay; the likelihood of the readings by it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, hypot, limit, log, maximum, minimum, sqrt, where
from tierod.monitors.condition.kinds.catalogue import Fit, KindState, SlopeFit

DELAYS = (0.03, 0.05, 0.07, 0.09, 0.12, 0.15, 0.19, 0.24, 0.3, 0.37, 0.45, 0.55)
"""Delays that are compared [s], about a quarter apart: what a delay is wrong by makes a parabola between them."""

DENSE = tuple(round(0.02 * k, 2) for k in range(1, 28))
"""Likewise, of a signal that jumps: two samples beside its delay nothing fits any more."""

ROUGH = 60.0
"""What a delay leaves over is noise of up to so many times the variance of the prediction, which is more than a torque
that jumps leaves a sample beside its delay; beyond that the delay is less and less likely."""
INFLUENCE = 8.0
"""Deviations beyond which a reading counts no more against a kind: what a fault was for seconds is not unlearnt from
the first readings after it, which have yet to show that it is gone."""
PRICE = 5.0
"""Of a delay against noise [nat]: one more thing to choose, known to a hundredth of what it may be."""


def delays_of(jumps: bool, sample_time: float) -> tuple[int, ...]:
    """The delays that are compared of a sensor, in samples.

    Args:
        jumps: whether its signal does
        sample_time: [s]
    """
    delays = DENSE if jumps else DELAYS
    return tuple(sorted({max(round(delay / sample_time), 1) for delay in delays}))


def log_density(off: Scalar, variance: Scalar, share: Scalar) -> Scalar:
    """Contribution of one reading to a log-likelihood.

    Args:
        off: reading less what was expected
        variance: of that
        share: of an independent reading that this one counts for
    """
    return -0.5 * share * (minimum(off * off / variance, INFLUENCE * INFLUENCE) + log(2.0 * math.pi * variance))


def fitted(fit: Fit, reading: Scalar, row: Scalar, square: Scalar, alike: Scalar, share: Scalar) -> Fit:
    """One parameter, one reading on: reading = row * parameter.

    Args:
        fit: before
        reading: of the sensor, or what it is off by
        row: factor of the parameter
        square: variance of the reading
        alike: samples over which errors are alike
        share: see `log_density`
    """
    off, known = reading - row * fit.value, row * row * fit.variance
    gain = fit.variance * row / (known + square * alike)
    return Fit(
        fit.value + gain * off,
        maximum(fit.variance - gain * row * fit.variance, 0.0),
        fit.score + log_density(off, known + square, share),
    )


def sloped(fit: SlopeFit, off: Scalar, time: Scalar, square: Scalar, alike: Scalar, share: Scalar) -> SlopeFit:
    """Start and slope, one deviation on.

    Args:
        fit: before
        off: deviation of the reading
        time: since the start
        square: variance of the deviation
        alike: samples over which errors are alike
        share: see `log_density`
    """
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
    """Score, delay, standard deviation and effect, from a parabola through the best of the delays compared.

    Squared deviations of a signal that moves evenly grow with the square of what a delay is wrong by, so that their
    least between those compared is known too. What a delay leaves over is noise of unknown magnitude: a prediction is
    never of the very form of a signal.

    Args:
        state: with squared deviations of each delay
        lines: the delays, in samples
        step: time of a sample [s]; readings come at one or the next
        longer: how much longer errors are alike in what a delay is uncertain by than in what is likely
        prediction: of this reading, undelayed
    """
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
    share = limit(rest, 1.0, ROUGH)
    return (
        -0.5 * (counted * (log(share) + rest / share) + state.common) - PRICE,
        step * place,
        step * hypot(width * sqrt(share * longer), 0.5),
        between(place, *best[::2]),
    )


def lowest(places: Sequence[Scalar], values: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
    """Minimum of a parabola through three points between the outer ones, its value there, and its width.

    Args:
        places: ascending
        values: at these places; the middle one is the lowest
    """
    left, right = places[1] - places[0], places[2] - places[1]
    down, up = (values[1] - values[0]) / left, (values[2] - values[1]) / right
    bend = maximum((up - down) / (0.5 * (left + right)), 1e-9)
    slope = (down * right + up * left) / (left + right)
    shift = limit(-slope / bend, -left, right)
    depth = values[1] + shift * (slope + 0.5 * bend * shift)
    return places[1] + shift, maximum(depth, 0.0), minimum(sqrt(2.0 / bend), places[2] - places[0])


def between(place: Scalar, places: Sequence[Scalar], values: Sequence[Scalar]) -> Scalar:
    """A value between those at three places, by the nearest two.

    Args:
        place: of the value, between the outer ones
        places: ascending
        values: at these places
    """
    early = (values[1] - values[0]) / (places[1] - places[0])
    late = (values[2] - values[1]) / (places[2] - places[1])
    return values[1] + (place - places[1]) * where(place < places[1], early, late)


def likeliest(options: Sequence[tuple[Scalar, ...]], doubt: Scalar) -> tuple[Scalar, ...]:
    """Number, magnitude and its deviation of the likeliest kind, and the mildest effect of all that it may well be.

    Args:
        options: number of a kind, whether it may be named, its score, magnitude, deviation, effect; the first may be
        doubt: by which scores may be below that of the likeliest [nat]
    """
    best = options[0]
    for option in options[1:]:
        better = both(option[1], option[2] > best[2])
        best = tuple(where(better, new, old) for new, old in zip(option, best, strict=True))
    effect = best[-1]
    for option in options:
        milder = all_of(option[1], option[2] > best[2] - doubt, absolute(option[-1]) < absolute(effect))
        effect = where(milder, option[-1], effect)
    return best[0], *best[3:5], effect
