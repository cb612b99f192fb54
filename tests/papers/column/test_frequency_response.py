"""Computed and measured frequency responses."""

import math

import control
import numpy as np
import pytest
from scipy import signal

from methods.analysis.column_sets import column
from tierod.core.errors import InputError, ParameterError
from tierod.models.linear import LinearSystem, sampled
from tierod_lab.papers.column.frequency_response import (
    decibels,
    frequency_response,
    largest_difference,
    measured_response,
    phase,
)

FREQUENCY = np.geomspace(0.1, 300.0, 60)


def test_a_first_order_lag_in_closed_form():
    lag = LinearSystem.of([[-5.0]], [[1.0]], [[5.0]])
    gain = frequency_response(lag, FREQUENCY).of("y0", "u0")
    np.testing.assert_allclose(gain, 1.0 / (1.0 + 2j * np.pi * FREQUENCY / 5.0))
    corner = frequency_response(lag, 5.0 / (2.0 * np.pi)).of("y0", "u0")
    assert decibels(corner)[0] == pytest.approx(-3.0103, abs=1e-4)
    assert phase(corner)[0] == pytest.approx(-45.0)


@pytest.mark.parametrize("output", [0, 1, 2])
def test_the_column_as_python_control_sees_it(output):
    system = column()
    found = frequency_response(system, FREQUENCY).gain[:, output, 0]
    peer = control.ss(system.A, system.B, system.C, system.D)
    np.testing.assert_allclose(found, peer(2j * np.pi * FREQUENCY)[output, 0], rtol=1e-8)


def test_a_sampled_system_answers_like_the_held_one():
    lag = LinearSystem.of([[-5.0]], [[1.0]], [[5.0]])
    held = frequency_response(sampled(lag, 1e-3), FREQUENCY[:30], 1e-3).gain
    step = 2j * np.pi * FREQUENCY[:30] * 1e-3
    expected = frequency_response(lag, FREQUENCY[:30]).gain[:, 0, 0] * (1.0 - np.exp(-step)) / step
    np.testing.assert_allclose(held[:, 0, 0], expected, rtol=2e-3)


def test_phase_does_not_jump():
    assert (
        np.abs(np.diff(phase(frequency_response(column(), FREQUENCY).of("driver_torque", "motor_torque")))).max() < 180
    )
    assert np.isnan(phase(np.array([1.0 + 0j, np.nan, 1j]))).tolist() == [False, True, False]


def test_a_gain_that_is_infinite_is_refused():
    with pytest.raises(ParameterError, match="infinite"):
        frequency_response(LinearSystem.of([[0.0]], [[1.0]], [[1.0]]), 0.0)


def test_unknown_names_are_refused():
    with pytest.raises(ParameterError, match="did you mean 'driver_torque'"):
        frequency_response(column(), 1.0).of("driver_torqe", "motor_torque")


def test_the_largest_difference_is_a_singular_value():
    one = LinearSystem.of([[-1.0]], np.zeros((2, 1)), np.zeros((1, 2)), np.diag([3.0, 4.0]))
    other = LinearSystem.of([[-1.0]], np.zeros((2, 1)), np.zeros((1, 2)), np.diag([1.0, -1.0]))
    assert largest_difference(one, other, [1.0, 2.0]) == pytest.approx(5.0)


RATE = 200.0


def noisy(seed, seconds=200.0, noise=0.5):
    rng = np.random.default_rng(seed)
    given = rng.normal(size=int(seconds * RATE))
    b, a = signal.butter(2, 20.0, fs=RATE)
    return given, signal.lfilter(b, a, given) + noise * rng.normal(size=len(given)), (b, a)


def truth(filter, frequency):
    return signal.freqz(*filter, worN=frequency, fs=RATE)[1]


def test_spectra_are_those_of_scipy():
    given, found, _ = noisy(1)
    ours = measured_response(given, found, RATE, 2.0, math.inf)
    options = {"fs": RATE, "nperseg": 400, "detrend": "constant"}
    cross, power = signal.csd(given, found, **options)[1], signal.welch(given, **options)[1]
    np.testing.assert_allclose(ours.gain, (cross / power)[1:], rtol=1e-9)
    np.testing.assert_allclose(ours.coherence, signal.coherence(given, found, **options)[1][1:], rtol=1e-9)


def test_the_band_covers_the_truth_as_often_as_it_says():
    inside = []
    for seed in range(20):
        given, found, filter = noisy(seed, 60.0)
        ours = measured_response(given, found, RATE, 1.0).between(1.0, 40.0)
        low, high = ours.band()
        true = np.abs(truth(filter, ours.frequency))
        inside += ((low <= true) & (true <= high)).tolist()
    assert 0.92 < np.mean(inside) < 0.98


def test_coherence_shows_how_much_is_noise():
    given, found, _ = noisy(2, noise=0.0)
    clean = measured_response(given, found, RATE, 2.0).between(1.0, 15.0)
    assert clean.coherence.min() > 0.99
    given, found, _ = noisy(2, noise=1.0)
    low = measured_response(given, found, RATE, 2.0).between(1.0, 10.0)
    assert np.median(low.coherence) == pytest.approx(0.5, abs=0.05)


def test_the_band_covers_the_truth_under_a_sweep_too():
    time = np.arange(0.0, 100.0, 1.0 / RATE)
    sweep = signal.chirp(time, 0.5, 100.0, 40.0)
    inside = []
    for seed in range(20):
        noise = 0.2 * np.random.default_rng(seed).normal(size=len(time))
        ours = measured_response(sweep, 2.0 * sweep + noise, RATE, 2.0).between(2.0, 38.0)
        low, high = ours.band()
        inside += ((low <= 2.0) & (high >= 2.0)).tolist()
    assert 0.92 < np.mean(inside) < 0.99


def test_an_input_in_one_piece_has_the_band_of_the_noise_in_all_others():
    given = np.zeros(40000)
    given[1190:1210] = 50.0 * np.hanning(20)
    inside = []
    for seed in range(20):
        found = 2.0 * given + np.random.default_rng(seed).normal(size=len(given))
        low, high = measured_response(given, found, RATE, 2.0).between(1.0, 10.0).band()
        inside += ((low <= 2.0) & (high >= 2.0)).tolist()
    assert 0.85 < np.mean(inside) < 0.99


def test_pieces_with_gaps_are_left_out():
    given, found, filter = noisy(3)
    found[5000:5100] = np.nan
    ours = measured_response(given, found, RATE, 2.0).between(1.0, 15.0)
    np.testing.assert_allclose(ours.gain, truth(filter, ours.frequency), atol=0.3)


def test_no_input_gives_no_gain():
    ours = measured_response(np.zeros(4000), np.ones(4000), RATE, 2.0)
    assert np.isnan(ours.gain).all()
    assert not ours.usable().any()
    assert np.isnan(ours.band()).all()


@pytest.mark.parametrize(("count", "other"), [(300, 300), (4000, 3999)])
def test_signals_that_do_not_fit_are_refused(count, other):
    with pytest.raises(InputError):
        measured_response(np.zeros(count), np.zeros(other), RATE, 2.0)


def test_neighbouring_frequencies_are_averaged_in_bands():
    given, found, _ = noisy(4, noise=0.0)
    lines, bands = (measured_response(given, found, RATE, 2.0, width) for width in (math.inf, 12.0))
    assert len(bands.frequency) < len(lines.frequency) / 2
    ratios = bands.frequency[1:] / bands.frequency[:-1]
    assert ratios[bands.frequency[1:] > 20.0].min() == pytest.approx(2 ** (1 / 12), rel=0.03)
    near = np.abs(lines.frequency - bands.frequency[-5]) <= 0.03 * bands.frequency[-5]
    assert abs(bands.gain[-5]) == pytest.approx(abs(lines.gain[near].mean()), rel=0.1)


def test_wrong_settings_are_refused():
    with pytest.raises(ParameterError, match="bands is 0"):
        measured_response(np.zeros(4000), np.zeros(4000), RATE, bands=0.0)
    with pytest.raises(ParameterError, match="above zero"):
        measured_response(np.zeros(4000), np.zeros(4000), 0.0)


def test_where_one_piece_alone_holds_the_input_the_noise_has_a_degree_of_freedom_less():
    """The noise's power at a frequency, known from the white noise, is what the stated deviation stands for."""
    rate, piece, sigma, count = 256.0, 1.0, 0.3, 4
    length = int(rate * piece)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    found = []
    for seed in range(8):
        random = np.random.default_rng(seed)
        samples = (count + 1) * length // 2
        burst = np.zeros(samples)
        burst[length + length // 2 - 8 : length + length // 2 + 8] = 50.0 * random.normal(size=16)
        output = 2.0 * burst + sigma * random.normal(size=samples)
        response = measured_response(burst, output, rate, piece, np.inf)
        pieces = np.lib.stride_tricks.sliding_window_view(burst, length)[:: length // 2]
        spectra = np.fft.rfft((pieces - pieces.mean(axis=1, keepdims=True)) * window, axis=1)[:, 1:]
        power = (np.abs(spectra) ** 2).sum(axis=0)
        absolute = response.relative_deviation * np.abs(response.gain)
        found.append(2.0 / (1.0 + 2.0 / 36.0) * absolute**2 * power)
    noise = sigma**2 * np.sum(window**2)
    assert np.median(np.mean(found, axis=0)) == pytest.approx(noise, rel=0.12)
