"""Fits of a faulty sensor's readings by an offset, a factor, a slope or a delay, with their log-likelihoods."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, hypot, limit, log, maximum, minimum, sqrt, where
from tierod.monitors.condition.kinds.catalogue import Fit, KindState, SlopeFit

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
PRICE = 5.0
"""Penalty of a delay against noise [nat], for one more free parameter, known to a hundredth of its range."""


def delays_of(jumps: bool, sample_time: float) -> tuple[int, ...]:
    """Delays that are compared for a sensor, in samples.

    Args:
        jumps: whether its signal has jumps
        sample_time: sampling interval [s]
    """
    delays = DENSE if jumps else DELAYS
    return tuple(sorted({max(round(delay / sample_time), 1) for delay in delays}))


def log_density(off: Scalar, variance: Scalar, share: Scalar) -> Scalar:
    """Contribution of one reading to a log-likelihood.

    Args:
        off: reading less expected reading
        variance: variance of that difference
        share: weight of the reading, below 1 for autocorrelated errors
    """
    return -0.5 * share * (minimum(off * off / variance, INFLUENCE * INFLUENCE) + log(2.0 * math.pi * variance))


def fitted(fit: Fit, reading: Scalar, row: Scalar, square: Scalar, alike: Scalar, share: Scalar) -> Fit:
    """Recursive least squares for one parameter: reading = row * parameter.

    Args:
        fit: estimate before the reading
        reading: reading of the sensor, or its deviation from the prediction
        row: regressor
        square: variance of the reading
        alike: correlation time of the errors, in samples
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
    """Recursive least squares for start and slope of a deviation.

    Args:
        fit: estimate before the reading
        off: deviation of the reading from its prediction
        time: time since the start [s]
        square: variance of the deviation
        alike: correlation time of the errors, in samples
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
    """Fit of a delay by a parabola through the squared deviations of the best compared delay and its neighbours.

    For a smooth signal the squared deviations grow with the square of the error of the delay, so that their minimum
    between the compared delays follows. The residual counts as noise of unknown variance, since a prediction never has
    exactly the shape of the signal.

    Args:
        state: state with the squared deviations of each delay
        lines: compared delays, in samples
        step: sampling interval [s]; rounding to it is a part of the uncertainty
        longer: correlation time for the uncertainty of magnitudes over that for the likelihoods [-]
        prediction: prediction of this reading, without delay

    Returns:
        log-likelihood [nat], delay [s], its standard deviation [s], and its effect on this reading
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
    """Minimum of a parabola through three points between the outer ones, its value there, and its width.

    Args:
        places: three abscissae, ascending
        values: values there, of which the middle one is the lowest
    """
    left, right = places[1] - places[0], places[2] - places[1]
    down, up = (values[1] - values[0]) / left, (values[2] - values[1]) / right
    bend = maximum((up - down) / (0.5 * (left + right)), 1e-9)
    slope = (down * right + up * left) / (left + right)
    shift = limit(-slope / bend, -left, right)
    depth = values[1] + shift * (slope + 0.5 * bend * shift)
    return places[1] + shift, maximum(depth, 0.0), minimum(sqrt(2.0 / bend), places[2] - places[0])


def between(place: Scalar, places: Sequence[Scalar], values: Sequence[Scalar]) -> Scalar:
    """Linear interpolation between three points.

    Args:
        place: abscissa, between the outer ones
        places: three abscissae, ascending
        values: values there
    """
    early = (values[1] - values[0]) / (places[1] - places[0])
    late = (values[2] - values[1]) / (places[2] - places[1])
    return values[1] + (place - places[1]) * where(place < places[1], early, late)


def likeliest(options: Sequence[tuple[Scalar, ...]], doubt: Scalar) -> tuple[Scalar, ...]:
    """Number, magnitude and standard deviation of the most likely kind, and the smallest effect of all likely kinds.

    Args:
        options: per kind its number, whether it may be named, score [nat], magnitude, standard deviation and effect;
            the first kind may always be named
        doubt: difference of scores within which a kind is as likely as the best [nat]
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
