"""The filter that leaves out what a hypothesis suspects: its corrections in closed form, and drives of another car."""

import math
from functools import lru_cache

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from monitors.condition.nominal_filter import nominal_filter
from tierod.core.block import rebuild
from tierod.core.graph import scan, trace
from tierod.methods.estimators.kernels import correct, pack, unpack
from tierod.monitors.condition.filter_updates import logarithm, spread_of, update
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.signals import ACTUATORS, MOTORS, OF_AUTOMATED, ConditionSample, hypotheses
from tierod.monitors.condition.vehicle_filter import LIMITS, SENSOR_NOISE, ModelError, widened
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import Drive, Injected, lost, vehicle
from tierod_lab.papers.condition.recorded import recorded

CHANCE = np.random.default_rng(4)
ROOT = CHANCE.normal(size=(4, 4))
COVARIANCE = ROOT @ ROOT.T
ROWS = CHANCE.normal(size=(3, 4))
NOISE = (0.5, 0.2, 1.5)
INNOVATIONS = (0.7, -1.1, 0.4)
FAR = 1e3


def corrected(innovations=INNOVATIONS, used=(1.0, 1.0, 1.0), influence=FAR):
    return update(pack(COVARIANCE.tolist()), ROWS.tolist(), innovations, NOISE, NOISE, used, influence)


def test_it_is_the_joint_update():
    ours = corrected()
    theirs = correct(pack(COVARIANCE.tolist()), ROWS.tolist(), INNOVATIONS, NOISE)
    np.testing.assert_allclose(ours.shift, theirs.shift, rtol=1e-12)
    np.testing.assert_allclose(ours.covariance, theirs.covariance, rtol=1e-12, atol=1e-15)
    assert sum(value * value for value in ours.whitened) == pytest.approx(theirs.nis)


def test_whitened_innovations_make_the_density_of_all_readings():
    ours = corrected()
    spread = ROWS @ COVARIANCE @ ROWS.T + np.diag(NOISE)
    logs = sum(math.log(2.0 * math.pi * each) + math.log(wide) for each, wide in zip(NOISE, ours.widening, strict=True))
    density = -0.5 * (sum(value * value for value in ours.whitened) + logs)
    assert density == pytest.approx(multivariate_normal.logpdf(INNOVATIONS, cov=spread))


@pytest.mark.parametrize("lost", [math.nan, 1e9])
def test_what_is_not_used_changes_nothing_whatever_it_reads(lost):
    left_out = corrected((INNOVATIONS[0], lost, INNOVATIONS[2]), used=(1.0, 0.0, 1.0))
    without = update(
        pack(COVARIANCE.tolist()), ROWS[[0, 2]].tolist(), INNOVATIONS[::2], NOISE[::2], NOISE[::2], (1.0, 1.0), FAR
    )
    np.testing.assert_allclose(left_out.shift, without.shift)
    np.testing.assert_allclose(left_out.covariance, without.covariance)
    assert left_out.whitened[1] == 0.0
    assert left_out.widening[1] == 1.0


def test_an_odd_reading_moves_the_mean_no_further_than_its_influence():
    far, farther = (corrected((size, 0.0, 0.0), used=(1.0, 0.0, 0.0), influence=3.0) for size in (1e3, 1e4))
    np.testing.assert_allclose(far.shift, farther.shift)
    variance = ROWS[0] @ COVARIANCE @ ROWS[0] + NOISE[0]
    np.testing.assert_allclose(far.shift, 3.0 * COVARIANCE @ ROWS[0] / math.sqrt(variance))
    assert farther.whitened[0] == pytest.approx(10.0 * far.whitened[0])


def test_the_spread_of_a_reading():
    assert spread_of(pack(COVARIANCE.tolist()), ROWS[0].tolist()) == pytest.approx(ROWS[0] @ COVARIANCE @ ROWS[0])
    assert np.array(unpack(pack(COVARIANCE.tolist()))) == pytest.approx(COVARIANCE)


@pytest.mark.parametrize("value", [1e-6, 0.3, 1.0, 2.0, 1e3, 1e6])
def test_the_logarithm_is_one(value):
    assert logarithm(value) == pytest.approx(math.log(value), abs=1e-8)


def test_the_logarithm_of_a_very_large_number_is_good_to_a_thousandth():
    assert logarithm(1e20) == pytest.approx(math.log(1e20), abs=1e-3)


SETTLED = 300
"""Samples until the car rolls."""
FAULT = slice(1500, 2400)
SIZES = dict(zip(OF_AUTOMATED, (2.0, 2.0, 0.3, 1.5, 3.0, 250.0), strict=True))
CLOSE = dict(zip(OF_AUTOMATED, (0.05, 0.05, 0.01, 0.1, math.inf, 45.0), strict=True))
"""Errors of what replaces a sensor; the steering torque jumps between samples, by how much is unknown."""
SINGLES = {each.name: each for each in hypotheses() if len(each.suspects) < 2}
BOTH_MOTORS = next(each for each in hypotheses() if each.suspects == MOTORS)


@lru_cache(maxsize=8)
def drive(*injected):
    recording = recorded(Drive("short-round", 24.0, 0, 5, injected))
    return aligned(recording), recording


def run(names, samples):
    return [scan(nominal_filter().leaving_out(SINGLES[name]), samples) for name in names]


def test_all_hypotheses_share_one_compiled_structure():
    graphs = {id(trace(nominal_filter().leaving_out(each))) for each in hypotheses()}
    assert len(graphs) == 1
    held = [
        each.name for each in hypotheses() if nominal_filter().leaving_out(each).model_error.wheel_speed_scale < 0.01
    ]
    assert len(held) == 3 + 12 + 12, "what leaves out a wheel or the yaw rate trusts the calibration of the wheels"
    sure = [each.name for each in hypotheses() if nominal_filter().leaving_out(each).model_error.drive_excess < 0.02]
    assert sure == [name for each in hypotheses() if "drive" in (name := each.name)]
    pair, drives = (nominal_filter().leaving_out(hypotheses()[k]) for k in (-3, -1))
    pair, drives = pair.trusted, drives.trusted
    assert (pair.tie_rod_force, pair.drive_right, pair.yaw_rate) == (0.0, 0.0, 1.0)
    assert (drives.drive_left, drives.drive_right, drives.yaw_rate) == (0.0, 0.0, 1.0)


def test_healthy_readings_are_consistent_with_their_predictions():
    samples, _ = drive()
    (healthy,) = run(["healthy"], samples)
    for name in OF_AUTOMATED:
        error = samples[:, OF_AUTOMATED.index(name)] - healthy[f"prediction.{name}"]
        assert 0.5 < np.nanmean((error / healthy[f"deviation.{name}"])[SETTLED:] ** 2) < 1.5
    assert np.all(healthy["moving"][SETTLED:] == 1.0)
    assert np.all(healthy["driven"] == 1.0)
    assert healthy["moving"][50] == 0.0


@pytest.mark.parametrize(("name", "close"), CLOSE.items())
def test_a_sensor_that_is_left_out_is_foretold_all_the_same(name, close):
    samples, recording = drive()
    lost = samples.copy()
    lost[SETTLED:, OF_AUTOMATED.index(name)] = np.nan
    left_out, without = (scan(nominal_filter().leaving_out(SINGLES[name]), each) for each in (samples, lost))
    estimate = left_out[f"estimate.{name}"]
    np.testing.assert_array_equal(estimate, without[f"estimate.{name}"])
    reading = samples[SETTLED:, OF_AUTOMATED.index(name)]
    truth = recording[f"truth_{name}"].values[SETTLED:] + vehicle(0).sensors[name].bias
    assert np.sqrt(np.mean((estimate[SETTLED:] - truth) ** 2)) < close
    error = (reading - left_out[f"prediction.{name}"][SETTLED:]) / left_out[f"deviation.{name}"][SETTLED:]
    assert np.mean(np.abs(error) < 3.0) > 0.95


@pytest.mark.parametrize("name", OF_AUTOMATED)
def test_an_offset_is_explained_best_by_leaving_out_its_sensor(name):
    samples, _ = drive()
    faulty = samples.copy()
    faulty[FAULT, OF_AUTOMATED.index(name)] += SIZES[name]
    results = dict(zip(SINGLES, run(list(SINGLES), faulty), strict=True))
    evidence = {each: float(np.sum(result["log_likelihood"][FAULT])) for each, result in results.items()}
    assert max(evidence, key=evidence.get) == name
    soon = slice(FAULT.start, FAULT.start + 20)
    assert np.sum((results[name]["log_likelihood"] - results["healthy"]["log_likelihood"])[soon]) > 30.0


def test_without_a_fault_leaving_out_a_sensor_explains_less():
    samples, _ = drive()
    results = dict(zip(SINGLES, run(list(SINGLES), samples), strict=True))
    healthy = np.mean(results["healthy"]["log_likelihood"][SETTLED:])
    assert all(np.mean(results[name]["log_likelihood"][SETTLED:]) < healthy - 2.0 for name in OF_AUTOMATED)


@pytest.mark.parametrize("name", ACTUATORS)
def test_lost_torque_is_found_and_measured(name):
    samples, _ = drive(lost(name, 0.5, 15.0, 24.0))
    results = dict(zip(SINGLES, run(list(SINGLES), samples), strict=True))
    evidence = {each: float(np.sum(result["log_likelihood"][FAULT])) for each, result in results.items()}
    assert max(evidence, key=evidence.get) == name
    known = results[name]["loss_deviation"][1600:] < 0.05
    assert np.mean(results[name]["torque_loss"][1600:][known]) == pytest.approx(0.5, abs=0.1)


def test_no_motor_loses_more_than_it_gives_so_that_one_does_not_explain_the_loss_of_both():
    samples, _ = drive(lost("steering_motor_1", 1.0, 15.0, 24.0), lost("steering_motor_2", 1.0, 15.0, 24.0))
    (one,) = run(["steering_motor_2"], samples)
    both = scan(nominal_filter().leaving_out(BOTH_MOTORS), samples)
    assert np.max(one["torque_loss"]) == LIMITS.torque_loss < 1.2
    known = both["loss_deviation"][1600:] < 0.05
    assert np.mean(both["torque_loss"][1600:][known]) == pytest.approx(1.0, abs=0.05)
    assert np.mean((both["log_likelihood"] - one["log_likelihood"])[FAULT]) > 1.0


def test_a_total_loss_in_the_recording_is_like_one_that_the_loop_does_not_see():
    samples, _ = drive(Injected("yaw_rate", "loss", start=15.0, end=24.0))
    healthy, left_out = run(["healthy", "yaw_rate"], samples)
    assert np.sum((left_out["log_likelihood"] - healthy["log_likelihood"])[FAULT]) > 100.0


def test_missing_samples_and_wild_ones_leave_it_fault_free():
    samples, _ = drive()
    broken = samples.copy()
    broken[500:600] = np.nan
    broken[900:1000, :8] = np.where(np.random.default_rng(1).random((100, 8)) < 0.3, 1e12, broken[900:1000, :8])
    broken[1200, :] = np.inf
    (result,) = run(["healthy"], broken)
    assert np.all(np.isfinite(result.values))
    assert np.all(np.abs(result["speed"]) <= LIMITS.speed)
    assert np.all(result["log_likelihood"][500:600] == 0.0)
    fault_free = scan(nominal_filter(), samples)
    np.testing.assert_allclose(result["speed"][2000:], fault_free["speed"][2000:], atol=0.02)


def test_at_standstill_and_in_reverse_it_says_so_and_is_not_surprised():
    standing = np.zeros((400, len(ConditionSample._fields)))
    result = scan(nominal_filter(), standing)
    assert np.all(result["moving"][20:] == 0.0)
    reversing = standing.copy()
    reversing[:, :2] = -2.0
    result = scan(nominal_filter(), reversing)
    assert result["speed"][-1] == pytest.approx(-2.0, abs=0.05)
    assert result["moving"][-1] == 0.0


def test_brakes_that_the_drives_do_not_give_are_noticed():
    samples, _ = drive()
    braked = samples.copy()
    braked[1000:1010, ConditionSample._fields.index("longitudinal_acceleration")] -= 5.0
    result = scan(nominal_filter(), braked)
    assert np.all(result["driven"][1000:1010] == 0.0)
    assert result["driven"][999] == 1.0


def test_an_uncalibrated_vehicle_gets_wider_noises_and_a_known_one_the_usual():
    noise, error = widened(load("smartload"))
    assert noise.tie_rod_force > SENSOR_NOISE.tie_rod_force
    assert error.force_share > 2.0 * ModelError().force_share
    assert nominal_filter().model_error == ModelError()
    assert nominal_filter().sensor_noise == SENSOR_NOISE


@pytest.mark.parametrize(
    ("what", "factor"), [("radius", 1.1), ("mass", 1.1), pytest.param("mass", 0.9, marks=pytest.mark.slow)]
)
def test_a_load_and_tyres_that_have_changed_are_learnt(what, factor):
    """What the whole filter finds, against what was changed: push per mass, and readings per speed."""
    samples = aligned(recorded(Drive("short-round", 40.0, 0, 5, later=(what, factor))))
    rolling = nominal_filter().vehicle.rolling_mass / nominal_filter().vehicle.mass
    expected = {
        "wheel_speed_scale": 1.0 / factor - 1.0 if what == "radius" else 0.0,
        "drive_excess": 1.0 / factor - 1.0 if what == "radius" else (1.0 + rolling) / (factor + rolling) - 1.0,
    }
    learnt = rebuild(nominal_filter().init(), scan(nominal_filter(), samples).state.values.tolist()).mean
    for name, value in expected.items():
        assert getattr(learnt, name) == pytest.approx(value, abs=0.02)
