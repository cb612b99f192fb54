"""Signals made from others: causal, stated, noted."""

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.derive import RECIPES, backward_rate, complete, ingredients


def recording(*channels: Channel) -> Recording:
    return Recording({channel.name: channel for channel in channels})


def test_recipes_use_canonical_names():
    for recipe in RECIPES.values():
        assert recipe.name in SIGNALS
        assert all(need in SIGNALS for need in recipe.needs)


def test_rate_of_a_ramp():
    time = np.arange(0.0, 2.0, 0.01)
    made = complete(recording(Channel("steering_wheel_angle", time, 0.5 * time, "rad")), ["steering_wheel_rate"])
    rate = made["steering_wheel_rate"]
    assert rate.unit == "rad/s"
    assert np.isnan(rate.values[0])
    assert rate.values[1:] == pytest.approx(0.5)
    assert "backward difference" in rate.note


def test_the_rate_is_causal():
    time = np.arange(0.0, 1.0, 0.01)
    step = np.where(time >= 0.5, 1.0, 0.0)
    _, rate = backward_rate(Channel("steering_wheel_angle", time, step, "rad"))
    assert np.nanmax(np.abs(rate[time < 0.5])) == 0.0
    assert rate[time >= 0.56] == pytest.approx(0.0)
    assert np.nansum(rate) * 0.01 == pytest.approx(1.0, rel=0.2)


def test_no_rate_across_a_gap():
    time = np.concatenate((np.arange(0.0, 1.0, 0.01), 5.0 + np.arange(0.0, 1.0, 0.01)))
    _, rate = backward_rate(Channel("steering_wheel_angle", time, time, "rad"))
    assert np.isnan(rate[100])
    assert np.isfinite(rate[101:]).all()


def test_speed_is_the_mean_of_the_rear_wheels():
    time = np.arange(0.0, 1.0, 0.01)
    left = Channel("wheel_speed_rear_left", time, np.full(100, 10.0), "m/s")
    right = Channel("wheel_speed_rear_right", time + 0.002, np.full(100, 12.0), "m/s")
    speed = complete(recording(left, right), ["vehicle_speed"])["vehicle_speed"]
    assert np.isnan(speed.values[0])
    assert speed.values[1:] == pytest.approx(11.0)
    assert "mean of the wheel speeds" in speed.note


def test_a_wheel_that_fell_silent_does_not_count():
    time = np.arange(0.0, 2.0, 0.01)
    left = Channel("wheel_speed_rear_left", time, np.full(200, 10.0), "m/s")
    right = Channel("wheel_speed_rear_right", time[:100], np.full(100, 12.0), "m/s")
    speed = complete(recording(left, right))["vehicle_speed"]
    assert np.isnan(speed.values[time > 1.12]).all()


def test_what_is_there_stays_and_what_lacks_ingredients_stays_absent():
    time = np.arange(3.0)
    whole = recording(Channel("vehicle_speed", time, time, "m/s"))
    assert complete(whole) is whole
    assert "steering_wheel_rate" not in complete(whole, ["steering_wheel_rate"])


def test_ingredients():
    assert set(ingredients(["vehicle_speed", "yaw_rate"])) == {
        "vehicle_speed",
        "yaw_rate",
        "wheel_speed_rear_left",
        "wheel_speed_rear_right",
    }


ANGLE = np.linspace(0.0, 12.0, 400)
PHASES = {phase: 10.0 * np.cos(ANGLE - shift) for phase, shift in zip("abc", (0.0, 2.0944, 4.18879), strict=True)}
MILLISECONDS = np.arange(400) * 1e-3


def phases(names, offset=0.0):
    return [Channel(f"motor_current_{name}", MILLISECONDS, PHASES[name] + offset, "A", f"i_{name}") for name in names]


@pytest.mark.parametrize("names", ["abc", "ab"])
def test_two_phases_or_three_make_a_vector(names):
    made = complete(recording(*phases(names)), ["motor_current_alpha", "motor_current_beta"])
    assert made["motor_current_alpha"].values == pytest.approx(10.0 * np.cos(ANGLE), abs=1e-3)
    assert made["motor_current_beta"].values == pytest.approx(10.0 * np.sin(ANGLE), abs=1e-3)
    assert made["motor_current_alpha"].unit == "A"
    assert "Clarke" in made["motor_current_beta"].note


def test_what_three_phases_share_drops_out():
    made = complete(recording(*phases("abc", offset=2.0)), ["motor_current_alpha"])
    assert made["motor_current_alpha"].values == pytest.approx(10.0 * np.cos(ANGLE), abs=1e-3)


def test_a_vector_that_was_recorded_is_kept_and_one_phase_makes_none():
    own = Channel("motor_current_alpha", MILLISECONDS, np.zeros(400), "A")
    made = complete(recording(own, *phases("abc")), ["motor_current_alpha"])
    assert made["motor_current_alpha"].values.max() == 0.0
    assert "motor_current_alpha" not in complete(recording(*phases("a")), ["motor_current_alpha"])


def test_a_phase_that_is_missing_at_an_instant_makes_none_there():
    a, b = phases("ab")
    late = Channel(b.name, np.delete(b.time, slice(100, 110)), np.delete(b.values, slice(100, 110)), "A")
    alpha = complete(recording(a, late), ["motor_current_alpha"])["motor_current_alpha"].values
    assert np.isnan(alpha[101:109]).all()
    assert np.isfinite(np.delete(alpha, slice(99, 111))).all()


def test_ingredients_name_all_that_may_be_used():
    assert set(ingredients(["motor_voltage_beta"])) == {
        "motor_voltage_beta",
        "motor_voltage_a",
        "motor_voltage_b",
        "motor_voltage_c",
    }
