"""Signals made from others: causal, stated, noted."""

import numpy as np
import pytest

from tierod.derive import RECIPES, backward_rate, complete, ingredients
from tierod.recording import Channel, Recording
from tierod.signals import SIGNALS


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
