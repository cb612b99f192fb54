"""Frequency response of a linear system, and of two measured signals with coherence and confidence band (Welch)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.models.linear import LinearSystem, balance


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Complex gains from inputs to outputs."""

    frequency: np.ndarray  # [Hz], (frequencies,)
    gain: np.ndarray  # output over input, in their units, (frequencies, outputs, inputs)
    outputs: tuple[str, ...]  # outputs, inputs: names
    inputs: tuple[str, ...]

    def of(self, output: str, input: str) -> np.ndarray:
        """The gain from one input to one output, (frequencies,).

        Raises:
            ParameterError: no such name
        """
        for name, names in ((output, self.outputs), (input, self.inputs)):
            if name not in names:
                raise ParameterError(f"there is no frequency response of '{name}'{nearest(name, names)}")
        return self.gain[:, self.outputs.index(output), self.inputs.index(input)]


def frequency_response(
    system: LinearSystem, frequency: ArrayLike, sample_time: float | None = None
) -> FrequencyResponse:
    """Frequency response C (j 2 pi f - A)^-1 B + D, computed in balanced states.

    Args:
        system: continuous, or discrete where a sample_time is given
        frequency: [Hz]
        sample_time: of a discrete system [s]

    Raises:
        ParameterError: a frequency at which the gain is infinite, such as zero where an angle is free
    """
    frequency = np.atleast_1d(np.asarray(frequency, float))
    at = 2j * math.pi * frequency
    at = at if sample_time is None else np.exp(at * sample_time)
    n = len(system.A)
    scale = balance(system.A)
    A, B, C = system.A * scale / scale[:, None], system.B / scale[:, None], system.C * scale
    pencils = at[:, None, None] * np.eye(n) - A
    try:
        gain = C @ np.linalg.solve(pencils, np.broadcast_to(B.astype(complex), (len(at), *B.shape))) + system.D
    except np.linalg.LinAlgError:
        gain = np.full((1, 1, 1), np.inf)
    if not np.isfinite(gain).all():
        raise ParameterError(
            "the gain is infinite at one of the frequencies, an eigenvalue of the system; leave it out"
        )
    return FrequencyResponse(frequency, gain, system.outputs, system.inputs)


def decibels(gain: np.ndarray) -> np.ndarray:
    """Magnitude of a gain in decibels, 20 log10 [dB]."""
    return np.asarray(20.0 * np.log10(np.abs(gain)))


def phase(gain: np.ndarray) -> np.ndarray:
    """Unwrapped phase, starting between -180 and 180 degrees [deg]; NaN where the gain is NaN."""
    known = np.isfinite(gain)
    turned = np.full(gain.shape, np.nan)
    turned[known] = np.degrees(np.unwrap(np.angle(gain[known])))
    return turned


def largest_difference(one: LinearSystem, other: LinearSystem, frequency: ArrayLike) -> float:
    """The largest gain of the difference of two systems with the same inputs and outputs, over the frequencies [Hz].

    The gain is the largest singular value, in the units of inputs and outputs.
    """
    first, second = (frequency_response(system, frequency).gain for system in (one, other))
    return float(np.linalg.svd(first - second, compute_uv=False)[:, 0].max())


CONFIDENCE = 1.96  # Half width of the band of a gain [standard deviations]: 95 % of a normal distribution

FEWEST = 4  # Smallest number of pieces of a recording for a frequency response

_ALONE = 0.95  # share of the input's power in one piece, above which its residuals contain no information
_OVERLAP = 1.0 + 2.0 / 36.0  # Hann-windowed pieces that overlap by half correlate with 1/6


@dataclass(frozen=True, eq=False)
class MeasuredResponse:
    """Measured gain from one signal to another."""

    frequency: np.ndarray  # [Hz], (frequencies,)
    gain: np.ndarray  # complex, output over input; NaN where the input has no power
    coherence: np.ndarray  # share of the output's power that depends linearly on the input, 0 to 1
    # standard deviation of the magnitude over the magnitude, and of the phase [rad]; NaN where the input has no power
    relative_deviation: np.ndarray

    def band(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end of the 95 % confidence band of the magnitude."""
        size, spread = np.abs(self.gain), np.minimum(CONFIDENCE * self.relative_deviation, 0.999)
        return size * (1.0 - spread), size * (1.0 + spread)

    def usable(self, coherence: float = 0.5) -> np.ndarray:
        """Mask of frequencies with at least this coherence and a known standard deviation."""
        return np.asarray(np.isfinite(self.relative_deviation) & (self.coherence >= coherence))

    def between(self, low: float, high: float) -> MeasuredResponse:
        """The part at frequencies from low to high [Hz]."""
        chosen = (self.frequency >= low) & (self.frequency <= high)
        parts = (self.frequency, self.gain, self.coherence, self.relative_deviation)
        return MeasuredResponse(*(values[chosen] for values in parts))


def measured_response(
    given: np.ndarray, found: np.ndarray, rate: float, piece: float = 4.0, bands: float = 48.0
) -> MeasuredResponse:
    """The gain from one signal to another: cross spectrum over spectrum of the input (H1), averaged over pieces.

    Noise of the output does not bias it; noise of the input, and feedback from the output to the input, do. A piece
    must be longer than the decay time of the slowest vibration of interest.

    Args:
        given: input, evenly sampled; pieces with a missing sample (NaN) are left out
        found: output, evenly sampled with the same treatment of missing samples
        rate: sample rate [Hz]
        piece: length of the pieces, which overlap by half [s]; the frequencies are at least 1 / piece apart
        bands: number of bands per octave over which neighbouring frequencies are averaged too; inf for no such average.
            A band of width B lowers a peak by the share (B / half-power width)**2 / 3 of its power (Bendat, Piersol,
            section 8.5): 48 per octave keep it below 1 % down to 5 % of damping

    Raises:
        InputError: signals of different length, or too few pieces without a gap
        ParameterError: a rate, a piece or a number of bands that is not above zero

    Source: P. D. Welch, 1967; J. S. Bendat, A. G. Piersol, Random Data, 4th ed., section 9.2, for equal noise in all
    pieces; J. G. MacKinnon, H. White, 1985, for unequal noise.
    """
    if not 0.0 < rate < np.inf or not 0.0 < piece < np.inf:
        raise ParameterError(f"rate is {rate} Hz and piece {piece} s; expected both above zero")
    given, found = np.asarray(given, float), np.asarray(found, float)
    if given.shape != found.shape or given.ndim != 1:
        raise InputError(f"a frequency response needs two signals of one length, not {given.shape} and {found.shape}")
    length = max(round(piece * rate), 8)
    inputs, outputs = (_spectra(signal, length) for signal in (given, found))
    whole = np.isfinite(inputs).all(axis=1) & np.isfinite(outputs).all(axis=1)
    if np.count_nonzero(whole) < FEWEST:
        raise InputError(
            f"{np.count_nonzero(whole)} whole pieces of {piece:g} s are too few for a frequency response; "
            f"expected {FEWEST} or more, that is {0.5 * piece * (FEWEST + 1):g} s without a gap"
        )
    frequency = np.fft.rfftfreq(length, 1.0 / rate)[1:]
    starts = _band_starts(frequency, bands)
    inputs, outputs = inputs[whole][:, 1:], outputs[whole][:, 1:]
    power, other = (_sums(np.abs(spectra) ** 2, starts) for spectra in (inputs, outputs))
    cross = _sums(inputs.conj() * outputs, starts)
    driven = (power > 1e-12 * power.max()) & (other > 0.0)
    power, other = np.where(driven, power, 1.0), np.where(driven, other, 1.0)
    counts = np.diff(np.append(starts, len(frequency)))
    return MeasuredResponse(
        np.add.reduceat(frequency, starts) / counts,
        np.where(driven, cross / power, np.nan),
        np.where(driven, np.minimum(np.abs(cross) ** 2 / (power * other), 1.0), 0.0),
        np.where(driven, _relative_deviation(inputs, outputs, cross / power, power, starts), np.nan),
    )


def _band_starts(frequency: np.ndarray, bands: float) -> np.ndarray:
    if not bands > 0.0:
        raise ParameterError(f"bands is {bands}; expected a number per octave above zero")
    number = np.arange(len(frequency)) if np.isinf(bands) else np.floor(bands * np.log2(frequency / frequency[0]))
    return np.flatnonzero(np.diff(number, prepend=-1))


def _sums(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    return np.add.reduceat(values.sum(axis=0), starts)


def _relative_deviation(
    inputs: np.ndarray, outputs: np.ndarray, gain: np.ndarray, power: np.ndarray, starts: np.ndarray
) -> np.ndarray:
    """Standard deviation of a gain over its magnitude.

    The larger of two estimates: for equal noise in all pieces, and from the leave-one-out residuals of the pieces with
    input. The second includes disturbances that come with the input, such as friction, but needs more than one piece
    with input.
    """
    lengths = np.diff(np.append(starts, inputs.shape[1]))
    residuals = outputs - np.repeat(gain, lengths) * inputs
    share = np.add.reduceat(np.abs(inputs) ** 2, starts, axis=1) / power
    pulls = np.add.reduceat(inputs.conj() * residuals, starts, axis=1) / (1.0 - np.minimum(share, _ALONE))
    near, next_but_one = (1.0 - np.minimum(step / lengths, 1.0) for step in (1, 2))
    alike = _sums(np.abs(residuals) ** 2, starts) / (len(inputs) * lengths - 1.0)
    # Under a Hann window neighbouring frequencies correlate with 2/3, the next but one with 1/6.
    alike = alike * (1.0 + 2.0 * near * (2.0 / 3.0) ** 2 + 2.0 * next_but_one / 36.0) * power
    with_input = np.where(share.max(axis=0) < _ALONE, (np.abs(pulls) ** 2).sum(axis=0), 0.0)
    size = np.where(np.abs(gain) > 0.0, np.abs(gain), np.inf)
    return np.asarray(np.sqrt(0.5 * _OVERLAP * np.maximum(alike, with_input)) / (power * size))


def _spectra(signal: np.ndarray, length: int) -> np.ndarray:
    if len(signal) < length:
        return np.zeros((0, length // 2 + 1))
    pieces = np.lib.stride_tricks.sliding_window_view(signal, length)[:: length // 2]
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    return np.fft.rfft((pieces - pieces.mean(axis=1, keepdims=True)) * window, axis=1)
