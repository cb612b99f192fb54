"""The filters that leave out what a hypothesis suspects: corrections in closed form, and drives of other cars."""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tierod.core.graph import scan
from tierod.methods.estimators.kernels import correct, pack
from tierod.monitors.condition.filter_updates import update
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.low_grip import Lack, LowGrip, sliding
from tierod.monitors.condition.rolling_filter import SmallestSteps
from tierod.monitors.condition.signals import (
    ACTUATORS,
    DRIVES,
    OF_AUTOMATED,
    ConditionSample,
    Hypothesis,
    hypotheses,
)
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.vehicles import load
from tierod_lab.ground.courses import load as course
from tierod_lab.ground.courses.course import Adhesion, Along
from tierod_lab.ground.courses.roads import Halt
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import Drive, lost, vehicle
from tierod_lab.papers.condition.recorded import as_recorded, recorded

CAR = load("smartload")
CHANCE = np.random.default_rng(4)
ROOT = CHANCE.normal(size=(4, 4))
COVARIANCE = ROOT @ ROOT.T
ROWS = CHANCE.normal(size=(3, 4))
NOISE = (0.5, 0.2, 1.5)
INNOVATIONS = (0.7, -1.1, 0.4)
FAR = 1e3


def corrected(innovations=INNOVATIONS, used=(1.0, 1.0, 1.0), influence=FAR):
    return update(pack(COVARIANCE.tolist()), ROWS.tolist(), innovations, NOISE, NOISE, used, influence)


def test_sequential_updates_are_the_joint_one_and_give_the_density_of_all_readings():
    ours, theirs = corrected(), correct(pack(COVARIANCE.tolist()), ROWS.tolist(), INNOVATIONS, NOISE)
    np.testing.assert_allclose(ours.shift, theirs.shift, rtol=1e-12)
    np.testing.assert_allclose(ours.covariance, theirs.covariance, rtol=1e-12, atol=1e-15)
    spread = ROWS @ COVARIANCE @ ROWS.T + np.diag(NOISE)
    logs = sum(math.log(2.0 * math.pi * each) + math.log(wide) for each, wide in zip(NOISE, ours.widening, strict=True))
    density = -0.5 * (sum(value * value for value in ours.whitened) + logs)
    assert density == pytest.approx(multivariate_normal.logpdf(INNOVATIONS, cov=spread))


@pytest.mark.parametrize("lost", [math.nan, 1e9])
def test_what_is_not_used_changes_nothing_whatever_it_reads(lost):
    left_out = corrected((INNOVATIONS[0], lost, INNOVATIONS[2]), used=(1.0, 0.0, 1.0))
    kept = update(
        pack(COVARIANCE.tolist()), ROWS[[0, 2]].tolist(), INNOVATIONS[::2], NOISE[::2], NOISE[::2], (1.0, 1.0), FAR
    )
    np.testing.assert_allclose(left_out.shift, kept.shift)
    np.testing.assert_allclose(left_out.covariance, kept.covariance)


SETTLED = 300
"""Samples until the car rolls."""
WRONG = slice(1500, 2400)
SIZES = dict(zip(OF_AUTOMATED, (2.0, 2.0, 0.3, 1.5, 3.0, 250.0), strict=True))
CLOSE = dict(zip(OF_AUTOMATED, (0.05, 0.05, 0.01, 0.1, math.inf, 45.0), strict=True))
"""Errors of what replaces a sensor; the steering torque jumps between samples, by how much is unknown."""
SINGLES = {each.name: each for each in hypotheses() if len(each.suspects) < 2}


@lru_cache(maxsize=1)
def nominal_filter():
    """The filter of the nominal demonstrator, whose file has the offsets of its sensors and no spread."""
    sensors = vehicle(0).sensors
    known = {name: replace(each, standard_deviation=0.0) for name, each in CAR.parameters.items()}
    for name in ConditionSample._fields[:8]:
        if f"{name}_offset" in known:
            known[f"{name}_offset"] = replace(known[f"{name}_offset"], value=sensors[name].bias)
    return LeaveOutFilter.of_vehicle(replace(CAR, parameters=known))


@lru_cache(maxsize=8)
def drive(*injected):
    recording = recorded(Drive("short-round", 24.0, 0, 5, injected))
    return aligned(recording), recording


def scanned(names, samples):
    return [scan(nominal_filter().leaving_out(SINGLES[name]), samples) for name in names]


def evidence_of(samples):
    """Log-likelihood of the faulty samples by every single hypothesis, and its filter's outputs."""
    results = dict(zip(SINGLES, scanned(SINGLES, samples), strict=True))
    return {name: float(np.sum(each["log_likelihood"][WRONG])) for name, each in results.items()}, results


def test_healthy_readings_are_consistent_with_their_predictions_and_best_explained_by_no_fault():
    samples, _ = drive()
    results = dict(zip(SINGLES, scanned(SINGLES, samples), strict=True))
    healthy = results["healthy"]
    for name in OF_AUTOMATED:
        error = samples[:, OF_AUTOMATED.index(name)] - healthy[f"prediction.{name}"]
        assert 0.5 < np.nanmean((error / healthy[f"deviation.{name}"])[SETTLED:] ** 2) < 1.5
    means = {name: np.mean(each["log_likelihood"][SETTLED:]) for name, each in results.items()}
    assert all(means[name] < means["healthy"] - 2.0 for name in OF_AUTOMATED)


@pytest.mark.parametrize(("name", "close"), CLOSE.items())
def test_a_sensor_that_is_left_out_is_foretold_all_the_same(name, close):
    samples, recording = drive()
    gone = samples.copy()
    gone[SETTLED:, OF_AUTOMATED.index(name)] = np.nan
    left_out, without = (scan(nominal_filter().leaving_out(SINGLES[name]), each) for each in (samples, gone))
    estimate = left_out[f"estimate.{name}"]
    np.testing.assert_array_equal(estimate, without[f"estimate.{name}"])
    truth = recording[f"truth_{name}"].values[SETTLED:] + vehicle(0).sensors[name].bias
    assert np.sqrt(np.mean((estimate[SETTLED:] - truth) ** 2)) < close


@pytest.mark.parametrize("name", OF_AUTOMATED)
def test_an_offset_is_explained_best_by_leaving_out_its_sensor(name):
    faulty = drive()[0].copy()
    faulty[WRONG, OF_AUTOMATED.index(name)] += SIZES[name]
    evidence, _ = evidence_of(faulty)
    assert max(evidence, key=evidence.get) == name


@pytest.mark.parametrize("name", ACTUATORS[::2])
def test_lost_torque_is_found_and_measured(name):
    evidence, results = evidence_of(drive(lost(name, 0.5, 15.0, 24.0))[0])
    assert max(evidence, key=evidence.get) == name
    known = results[name]["loss_deviation"][1600:] < 0.05
    assert np.mean(results[name]["torque_loss"][1600:][known]) == pytest.approx(0.5, abs=0.1)


# From here on the filter of a car that is judged by its motion.


def step_after(readings):
    steps = SmallestSteps.unseen((0.5,))
    for each in readings:
        steps = steps.after((each,), (1e-6,))
    return steps.smallest[0]


def test_rounded_readings_show_their_step_and_no_rounding_residue_repetition_or_gap_does():
    fine = np.random.default_rng(1).normal(0.0, 0.3, 500).cumsum()
    assert step_after((0.0223 * np.round(fine / 0.0223)).tolist()) == pytest.approx(0.0223)
    assert step_after([0.0, 0.2, 0.2 + 1e-13, 0.4, math.nan, 0.4]) == pytest.approx(0.2)
    assert step_after([0.0, 0.0, math.nan]) == 0.5


# From here on the filter of sliding tyres, and the rule that says they slide.


def slides_in(recording):
    base = nominal_filter()
    lanes = [base, *(base.leaving_out(Hypothesis(name, (), (name,))) for name in DRIVES), sliding(base)]
    samples = aligned(recording)
    results = [scan(each, samples) for each in lanes]
    last, rule, found = results[-1], LowGrip(), []
    state = rule.init()
    for k in range(len(samples)):
        others = [each["log_likelihood"][k] for each in results[:-1]]
        lack = Lack(*(last[name][k] for name in ("lack", "lack_along", "given_along")))
        state, slides = rule.after(state, last["log_likelihood"][k], others, others[1:], lack, last["moving"][k], 0.01)
        found.append(bool(slides))
    return np.array(found)


def test_tyres_slide_soon_after_the_car_brakes_harder_than_ice_holds_and_as_long_as_it_does():
    """Brakes for a halt after 60 m of the long round, the last 30 m of ice."""
    car, sensors = vehicle(0)
    ice = Adhesion(window=Along(30.0, 76.0, 1.0), left=0.2, right=0.2)
    way = replace(course("long-round"), time=14.0, speed=9.0, halts=(Halt(60.0, 2.0),), conditions=(ice,))
    made = as_recorded(run(car, way, 14.0, 5, sensors).recording)
    asked = -(made["truth_drive_torque_left"].values + made["truth_drive_torque_right"].values) / CAR["wheel_radius"]
    lacks = asked - CAR["mass"] * -made["truth_longitudinal_acceleration"].values > 250.0
    found, moving = slides_in(made), made["truth_speed"].values > 1.0
    assert 0 < np.argmax(found) - np.argmax(lacks & moving) < 12
    assert found[lacks & moving].mean() > 0.95
    assert not found[: np.argmax(lacks & moving)].any()


def test_no_tyres_slide_where_a_drive_has_lost_torque():
    made = recorded(Drive("long-round", 46.0, 0, 300, (lost("drive_left", 0.5, 41.0, 46.0),)))
    assert np.max(np.abs(made["target_drive_torque_left"].values[4100:])) > 100.0
    assert not slides_in(made).any()
