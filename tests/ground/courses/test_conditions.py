import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses.conditions import (
    Adhesion,
    Along,
    Attention,
    Breeze,
    During,
    Grip,
    Gusts,
    HandTorque,
    Restlessness,
    Slope,
    Tremor,
    Unevenness,
)
from tierod_lab.ground.courses.course import Repeated, band_limited, combine, smooth_noise
from tierod_lab.ground.courses.lane import StraightLane

TIME = np.arange(0.0, 20.0, 0.01)
PLACE = 10.0 * TIME


def act(condition, seed=0):
    return condition.acting(np.random.default_rng(seed))(TIME, PLACE)


def test_a_step_begins_and_ends_on_the_instant():
    torque = act(HandTorque(During(5.0, 7.0), 1.5))["demand.hand_torque"]
    assert np.array_equal(torque, np.where((TIME >= 5.0) & (TIME < 7.0), 1.5, 0.0))


def test_a_ramp_is_smooth_and_symmetric():
    share = During(5.0, 9.0, ramp=1.0).share(TIME, PLACE)
    assert share[TIME.searchsorted(5.5)] == pytest.approx(0.5, abs=0.01)
    assert np.all(share[(TIME > 6.01) & (TIME < 7.99)] == 1.0)
    assert np.max(np.abs(np.diff(share))) <= 1.5 * 0.01 + 1e-9, "steepest in the middle of the ramp"
    inside = (TIME > 5.0) & (TIME < 9.0)
    assert np.all(share[~inside] == 0.0)
    assert np.allclose(share[inside], np.flip(share[inside]), atol=2e-2)


def test_a_window_of_place_follows_the_distance_and_comes_again():
    share = Along(20.0, 30.0, every=100.0).share(TIME, PLACE)
    assert np.array_equal(share, ((np.mod(PLACE, 100.0) >= 20.0) & (np.mod(PLACE, 100.0) < 30.0)).astype(float))


@pytest.mark.parametrize(("start", "end"), [(12.0, 14.0), (-3.0, 2.0), (-math.inf, 2.0), (8.0, 11.0)])
@pytest.mark.parametrize("ramp", [0.0, 0.5])
def test_a_window_comes_again_after_its_start_alike(start, end, ramp):
    once, expected = During(start, end, ramp), np.zeros(len(TIME))
    for shift in (0.0, 10.0, 20.0):
        share = once.share(TIME - shift, PLACE)
        since = shift if start == -math.inf else -math.inf
        expected = np.maximum(expected, 0.0 if share is None else np.where(since > TIME, 0.0, share))
    again = During(start, end, ramp, every=10.0).share(TIME, PLACE)
    np.testing.assert_allclose(again, expected, atol=1e-9)


def test_nothing_is_said_outside_a_window():
    assert act(Grip(During(100.0, 101.0))) == {}
    assert During().share(TIME, PLACE) == 1.0


def test_an_empty_window_is_refused():
    with pytest.raises(ParameterError, match="let its end come after its start"):
        Along(5.0, 5.0)


@pytest.mark.parametrize(
    ("condition", "levels"),
    [
        (Adhesion(left=0.3), {"road.adhesion_left": 0.3, "road.adhesion_right": 1.0}),
        (Slope(bank=0.05, grade=-0.1), {"road.bank_angle": 0.05, "road.grade_angle": -0.1}),
        (Breeze(crosswind=-15.0), {"wind.crosswind_speed": -15.0, "wind.headwind_speed": 0.0}),
        (HandTorque(torque=2.0), {"demand.hand_torque": 2.0}),
        (Grip(), {"demand.grip": 0.0}),
        (Attention(share=0.2), {"demand.attention": 0.2}),
    ],
)
def test_steady_conditions_set_their_columns(condition, levels):
    columns = act(condition)
    assert {name: (values.min(), values.max()) for name, values in columns.items()} == {
        name: (pytest.approx(level), pytest.approx(level)) for name, level in levels.items()
    }


def test_a_curve_goes_on_behind_its_beginning():
    curve = Repeated(np.array([0.0, 1.0, 4.0, 2.0]), 0.5)
    assert curve.at(np.array([-0.5, -0.25, 0.0, 0.25, 2.0])) == pytest.approx([2.0, 1.0, 0.0, 0.5, 0.0])


def test_shares_multiply_and_amounts_add():
    columns = {"demand.grip": np.full(3, 0.5), "road.bank_angle": np.full(3, 0.1)}
    combine(columns, {"demand.grip": np.full(3, 0.5), "road.bank_angle": np.full(3, 0.1)})
    assert np.allclose(columns["demand.grip"], 0.25)
    assert np.allclose(columns["road.bank_angle"], 0.2)


@pytest.mark.parametrize(
    ("condition", "name", "deviation"),
    [
        (Restlessness(deviation=0.1), "demand.steering_wheel_angle", 0.1),
        (Gusts(deviation=3.0), "wind.crosswind_speed", 3.0),
        (Unevenness(deviation=0.01), "road.bank_angle", 0.01),
        (Tremor(deviation=0.5), "demand.hand_torque", 0.5),
    ],
)
def test_random_conditions_have_their_size_and_no_mean(condition, name, deviation):
    time = np.arange(0.0, 2000.0, 0.01)
    values = condition.acting(np.random.default_rng(1))(time, 10.0 * time)[name]
    # Between its knots a smooth curve is the mean of two: its overall variance is 26/35 of theirs.
    assert np.std(values) == pytest.approx(deviation * math.sqrt(26.0 / 35.0), rel=0.1)
    assert abs(np.mean(values)) < 0.1 * deviation


def test_tremor_has_its_frequency():
    time = np.arange(0.0, 200.0, 0.01)
    torque = Tremor(frequency=9.0).acting(np.random.default_rng(1))(time, time)["demand.hand_torque"]
    power = np.abs(np.fft.rfft(torque)) ** 2
    frequency = np.fft.rfftfreq(len(time), 0.01)
    assert np.sum(power * frequency) / np.sum(power) == pytest.approx(9.0, abs=0.2)
    assert np.sum(power[np.abs(frequency - 9.0) < 2.0]) > 0.9 * np.sum(power)


def test_chance_is_the_seeds_alone():
    time = np.arange(50.0)
    one, same, other = (
        StraightLane(seed=seed, conditions=(Gusts(), Restlessness())).columns(time, time, 1.0, 0.0)
        for seed in (1, 1, 2)
    )
    for name in ("wind.crosswind_speed", "demand.steering_wheel_angle"):
        assert np.array_equal(one[name], same[name])
        assert not np.array_equal(one[name], other[name])


def test_a_condition_more_does_not_move_those_before_it():
    time = np.arange(50.0)
    alone = StraightLane(conditions=(Gusts(),)).columns(time, time, 1.0, 0.0)
    more = StraightLane(conditions=(Gusts(), Restlessness())).columns(time, time, 1.0, 0.0)
    assert np.array_equal(alone["wind.crosswind_speed"], more["wind.crosswind_speed"])


def test_smooth_noise_has_no_corners():
    curve = smooth_noise(np.random.default_rng(0), 1.0, 2.0, 0.01)
    # Steepest 1.5 times the straight rise between knots, at least one second apart.
    assert np.max(np.abs(np.diff(curve))) < 0.01 * 1.5 * 2.0 * np.max(np.abs(curve))
    assert np.max(np.abs(np.diff(curve, 2))) < 0.01**2 * 6.0 * 2.0 * np.max(np.abs(curve)) + 1e-9


def test_a_curve_begins_anew_after_its_end():
    curve = Repeated(np.array([0.0, 1.0, 3.0]), 2.0)
    assert np.allclose(curve.at(np.array([0.0, 1.0, 2.0, 5.0, 6.0, 7.0])), [0.0, 0.5, 1.0, 1.5, 0.0, 0.5])


def test_a_band_holds_all_power():
    curve = band_limited(np.random.default_rng(0), 0.5, 2.0, 100.0, 0.01)
    power, frequency = np.abs(np.fft.rfft(curve)) ** 2, np.fft.rfftfreq(len(curve), 0.01)
    assert np.std(curve) == pytest.approx(1.0)
    assert np.sum(power[(frequency > 0.49) & (frequency < 2.01)]) > 0.999999 * np.sum(power)
