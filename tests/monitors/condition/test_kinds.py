"""Kinds and sizes of faults of a made-up signal, against a prediction with errors that last."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.graph import batch, scan
from tierod.monitors.condition.kinds import KINDS, Fit, KindOfFault, SlopeFit, delays_of, fitted, lowest, sloped

RATE, START, END = 100.0, 500, 900
NOISE, ERROR = 0.02, 0.03
BLOCK = KindOfFault.of_sensor("wheel_speed_rear_left")
TIME = np.arange(1200) / RATE


def truth(seed):
    chance = np.random.default_rng(seed)
    phase = chance.uniform(0.0, 6.0)
    return 6.0 + 3.0 * np.sin(1.3 * TIME + phase) + np.sin(3.1 * TIME + 2.0 * phase)


def faulty(kind, size, value, chance):
    since = TIME - TIME[START]
    changed = {
        "loss": 0.0 * value,
        "stuck": np.full_like(value, value[START]),
        "offset": value + size,
        "gain": value * size,
        "outlier": value * size,
        "drift": value + size * since,
        "noise": value + size * chance.normal(size=len(value)),
        "delay": np.interp(TIME - (size or 0.0), TIME, value),
    }[kind]
    return np.where((np.arange(len(value)) >= START) & (np.arange(len(value)) < END), changed, value)


def samples(kind, size, seed=0, late=5):
    """Declared so many samples after the fault began; the prediction errs for some 0.1 s at a time."""
    chance = np.random.default_rng(seed)
    value = truth(seed)
    reading = faulty(kind, size, value + NOISE * chance.normal(size=len(value)), chance)
    error = np.zeros(len(value))
    for k in range(1, len(value)):
        error[k] = 0.8 * error[k - 1] + ERROR * 0.6 * chance.normal()
    deviation = np.full(len(value), np.hypot(NOISE, ERROR))
    index = np.arange(len(value))
    declared = ((index >= START + late) & (index < END)).astype(float)
    supports = np.where((index >= START) & (index < END), 1.0, -1.0)
    return np.column_stack([reading, value + error, deviation, declared, np.zeros(len(value)), supports])


CASES = [
    ("loss", 0.0), ("stuck", 0.0), ("offset", 2.0), ("offset", -0.6), ("gain", 1.5), ("gain", 0.7), ("drift", 0.3),
    ("drift", -0.5), ("noise", 0.5), ("delay", 0.2), ("delay", 0.1),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "size"), CASES)
def test_kind_and_size_are_right_after_two_seconds(kind, size):
    late = 50 if kind == "drift" else 5
    results = batch(BLOCK, [samples(kind, size, seed, late) for seed in range(20)])
    at = START + late + 200
    named = [KINDS[int(result["kind"][at]) - 1] for result in results]
    assert named.count(kind) >= 19
    sizes = np.array([result["magnitude"][at] for result, name in zip(results, named, strict=True) if name == kind])
    assert np.all(np.abs(sizes - size) <= 0.1 * abs(size) + 1e-12)


@pytest.mark.parametrize(("kind", "size"), [("offset", 2.0), ("gain", 1.5), ("noise", 0.5)])
def test_its_interval_holds_the_size_about_as_often_as_it_says(kind, size):
    results = batch(BLOCK, [samples(kind, size, seed) for seed in range(100, 160)])
    errors = [abs(result["magnitude"][START + 205] - size) / result["deviation"][START + 205] for result in results]
    assert np.mean(np.array(errors) < 2.0) > 0.85


def test_where_errors_last_the_size_is_less_certain():
    given = samples("offset", 2.0)
    short, long = (scan(replace(BLOCK, lasting=time), given) for time in (0.1, 2.5))
    late = slice(START + 50, END)
    np.testing.assert_allclose(long["deviation"][late], 5.0 * short["deviation"][late])
    np.testing.assert_array_equal(long["magnitude"], short["magnitude"])
    assert KindOfFault.of_sensor("steering_wheel_angle").lasting == 2.0


def test_a_large_factor_is_an_outlier_while_it_is_young():
    result = scan(BLOCK, samples("outlier", 3.0))
    kinds = result["kind"]
    assert KINDS[int(kinds[START + 60]) - 1] == "outlier"
    assert KINDS[int(kinds[START + 200]) - 1] == "gain"
    assert result["magnitude"][START + 60] == pytest.approx(3.0, rel=0.02)


def test_nothing_is_named_while_nothing_is_declared_and_all_is_forgotten_after():
    result = scan(BLOCK, samples("offset", 2.0))
    outside = np.r_[0 : START + 5, END:1200]
    assert not result["kind"][outside].any()
    assert not result["magnitude"][outside].any()
    again = samples("offset", 2.0)
    again[1000:, 0] -= 1.0
    again[1005:, 3] = 1.0
    assert scan(BLOCK, again)["magnitude"][-1] == pytest.approx(-1.0, abs=0.1)


@pytest.mark.parametrize(("kind", "size"), [("loss", 0.0), ("offset", 2.0), ("gain", 1.5), ("delay", 0.2)])
def test_its_effect_is_what_the_fault_adds(kind, size):
    given = samples(kind, size)
    result = scan(BLOCK, given)
    late = slice(START + 250, END)
    np.testing.assert_allclose(result["effect"][late], (given[:, 0] - given[:, 1])[late], atol=0.25)


def test_nothing_is_learnt_while_it_recovers():
    given = samples("offset", 2.0)
    given[800:END, 0] = given[800:END, 1]
    given[800:END, 4] = 1.0
    result = scan(BLOCK, given)
    assert (result["kind"][800:END] == 3.0).all()
    np.testing.assert_allclose(result["effect"][800:END], result["effect"][799])


def test_a_lost_reading_that_moves_again_as_it_should_is_revived():
    given = samples("loss", 0.0)
    given[800:END, 0] = given[800:END, 1] + 0.01 * np.sin(TIME[800:END])
    result = scan(BLOCK, given)
    assert (result["kind"][700:END] == 1.0).all()
    assert np.isinf(result["effect"][800:END]).all()
    assert np.isfinite(result["effect"][:800]).all()


def test_missing_readings_change_nothing():
    given = samples("offset", 2.0)
    given[600:620, 0] = np.nan
    result = scan(BLOCK, given)
    assert np.isfinite(result.values).all()
    assert result["magnitude"][-301] == pytest.approx(2.0, abs=0.1)


def test_a_delay_is_distinguished_from_readings_some_of_which_are_missing():
    given = samples("delay", 0.2)
    given[START:END:7, 0] = np.nan
    result = scan(BLOCK, given)
    assert KINDS[int(result["kind"][END - 1]) - 1] == "delay"
    assert result["magnitude"][END - 1] == pytest.approx(0.2, abs=0.02)


def test_delays_follow_the_sample_time():
    slow = KindOfFault.of_sensor("yaw_rate", 0.02)
    assert slow.delays == delays_of(False, 0.02)
    assert [0.02 * size for size in slow.delays][-3:] == pytest.approx([0.36, 0.44, 0.56])
    assert replace(slow, delays=(1, 2, 3)).init().delays == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("kind", "size"), [("offset", 2.0), ("gain", 1.5)])
def test_what_is_unknown_of_a_prediction_widens_the_size_and_spares_the_kind(kind, size):
    given = samples(kind, size)
    given[:, 1] += 0.3 * np.sin(0.8 * TIME)
    at = END - 1
    sure, outcome = (scan(block, given) for block in (BLOCK, replace(BLOCK, unknown=0.3)))
    assert KINDS[int(outcome["kind"][at]) - 1] == kind
    assert abs(outcome["magnitude"][at] - size) < 2.0 * outcome["deviation"][at]
    assert KINDS[int(sure["kind"][at]) - 1] != kind or abs(sure["magnitude"][at] - size) > 3.0 * sure["deviation"][at]


def grown(size, late, **changes):
    """A drift that is declared so many samples after it began."""
    given = samples("drift", size, late=late)
    return scan(replace(BLOCK, **changes), given), START + late


def test_what_a_late_declared_drift_grew_from_distinguishes_it_from_an_offset_at_once():
    result, at = grown(0.1, 350)
    assert KINDS[int(result["kind"][at + 2]) - 1] == "drift"
    assert result["magnitude"][at + 2] == pytest.approx(0.1, rel=0.1)
    blind, _ = grown(0.1, 350, away=1e9)
    assert KINDS[int(blind["kind"][at + 2]) - 1] != "drift"


def test_a_jump_after_a_small_lasting_error_is_an_offset_of_its_own():
    given = samples("offset", 2.0)
    given[100:, 0] += 0.1
    result = scan(BLOCK, given)
    assert KINDS[int(result["kind"][START + 205]) - 1] == "offset"
    assert result["magnitude"][START + 205] == pytest.approx(2.1, abs=0.03)


@pytest.mark.parametrize("late", [0.13, 0.21, 0.33, 0.41])
def test_a_delay_between_those_compared_is_found_by_its_parabola(late):
    result = scan(BLOCK, samples("delay", late))
    assert KINDS[int(result["kind"][START + 205]) - 1] == "delay"
    assert result["magnitude"][START + 205] == pytest.approx(late, abs=2.0 * result["deviation"][START + 205])
    assert result["deviation"][START + 205] < 0.05 * late + 0.01


def test_a_delay_of_a_signal_that_jumps_is_found():
    chance = np.random.default_rng(4)
    value = np.repeat(chance.normal(size=60), 20)
    reading = np.where(np.arange(1200) >= START, np.roll(value, 27), value) + 0.1 * chance.normal(size=1200)
    given = np.column_stack(
        [reading, value, np.full(1200, 0.12), np.arange(1200) > START + 20, np.zeros(1200), np.ones(1200)]
    )
    block = KindOfFault.of_sensor("steering_shaft_torque")
    result = scan(block, given)
    assert KINDS[int(result["kind"][START + 220]) - 1] == "delay"
    assert result["magnitude"][START + 220] == pytest.approx(0.27, abs=0.01)


def test_what_wanders_slowly_is_no_noise():
    given = samples("offset", 0.0, late=5)
    since = np.maximum(TIME - TIME[START], 0.0)
    given[:, 0] += 2.0 * np.sin(2.0 * since) * (since < 4.0)
    wandering = scan(BLOCK, given)["kind"][START + 150 : START + 250]
    assert (wandering != 7.0).all()
    assert (scan(replace(BLOCK, quick=0.0), given)["kind"][START + 150 : START + 250] == 7.0).any()


def test_noise_is_no_delay_of_next_to_nothing():
    block = KindOfFault.of_sensor("steering_shaft_torque")
    results = [scan(block, samples("noise", 0.5, seed)) for seed in range(40)]
    assert all(result["kind"][START + 205] == 7.0 for result in results)


def test_while_kinds_are_as_likely_the_effect_is_the_mildest_of_theirs():
    """At first an offset of -2 may as well be a factor that is small already: it is open until the truth moves."""
    given = samples("offset", -2.0)
    mild, bold = (scan(replace(BLOCK, doubt=nats), given)["effect"] for nats in (6.0, 0.0))
    assert (np.abs(mild) <= np.abs(bold) + 1e-12).all()
    early, late = slice(START + 5, START + 40), slice(START + 200, END)
    assert (np.abs(mild[early]) < np.abs(bold[early]) - 0.05).any()
    np.testing.assert_array_equal(mild[late], bold[late])


@pytest.mark.parametrize(("kind", "size"), [("offset", 0.06), ("gain", 1.5), ("noise", 0.05), ("drift", 0.01)])
@pytest.mark.parametrize("small", [0.01, 1.0])
def test_no_magnitude_is_named_whose_interval_contains_that_of_a_fault_free_sensor(kind, size, small):
    for result in batch(BLOCK, [_scaled(samples(kind, size, seed), small) for seed in range(20)]):
        named = result["kind"] > 0.5
        number = result["kind"][named].astype(int) - 1
        neutral = np.array([1.0 if KINDS[each] in ("gain", "outlier") else 0.0 for each in number])
        valued = ~np.isin([KINDS[each] for each in number], ("loss", "stuck"))
        away = np.abs(result["magnitude"][named] - neutral)[valued]
        assert (away > BLOCK.sure * result["deviation"][named][valued]).all()


def _scaled(given, factor):
    """Reading and prediction of a signal that hardly differs from zero, with the same errors."""
    given[:, 0] -= (1.0 - factor) * given[:, 1]
    given[:, 1] *= factor
    return given


def test_the_product_of_the_densities_is_that_of_all_readings_together():
    """The same as one normal density whose covariance holds the parameter's own variance."""
    chance = np.random.default_rng(1)
    rows, readings, square, before = chance.normal(size=5), chance.normal(size=5), 0.3, 2.0
    fit = Fit(1.0, before, 0.0)
    for reading, row in zip(readings, rows, strict=True):
        fit = fitted(fit, reading, row, square, 1.0, 1.0)
    covariance = before * np.outer(rows, rows) + square * np.eye(5)
    off = readings - rows
    whole = -0.5 * (off @ np.linalg.solve(covariance, off) + np.linalg.slogdet(2.0 * np.pi * covariance)[1])
    assert fit.score == pytest.approx(whole)
    information = 1.0 / before + rows @ rows / square
    assert fit.variance == pytest.approx(1.0 / information)
    assert fit.value == pytest.approx((1.0 / before + rows @ readings / square) / information)


def test_a_slope_is_that_of_least_squares_with_what_is_known_before():
    chance = np.random.default_rng(2)
    times, off, square = np.arange(8) * 0.1, chance.normal(size=8), 0.2
    fit = SlopeFit(0.0, 0.0, 0.5, 0.0, 4.0, 0.0)
    for time, each in zip(times, off, strict=True):
        fit = sloped(fit, each, time, square, 1.0, 1.0)
    rows = np.column_stack([np.ones(8), times])
    inverse = np.linalg.inv(np.diag([1.0 / 0.5, 1.0 / 4.0]) + rows.T @ rows / square)
    np.testing.assert_allclose([fit.start, fit.slope], inverse @ rows.T @ off / square)
    np.testing.assert_allclose([fit.start_variance, fit.covariance, fit.slope_variance], inverse[[0, 0, 1], [0, 1, 1]])


def test_the_lowest_point_of_a_parabola_is_found_where_it_is():
    places = (0.19, 0.24, 0.3)
    place, value, width = lowest(places, [3.0 + 400.0 * (each - 0.23) ** 2 for each in places])
    assert (place, value) == (pytest.approx(0.23), pytest.approx(3.0))
    assert width == pytest.approx(min((2.0 / 800.0) ** 0.5, 0.11))
