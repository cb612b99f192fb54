"""What the data show by themselves: gaps, rates and saturation."""

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.quality import channel_quality, median_rate
from tierod.io.readers import read

RANDOM = np.random.default_rng(4)
TIME = np.arange(0.0, 60.0, 0.01)


def quality(values, time=TIME, name="yaw_rate"):
    channel = Channel(name, time, np.asarray(values, dtype=float), SIGNALS[name].unit)
    return channel_quality(channel)


def remarks(values, time=TIME, name="yaw_rate") -> str:
    return " | ".join(quality(values, time, name).remarks)


def test_a_good_channel_earns_no_remark():
    found = quality(0.3 * np.sin(TIME) + 0.001 * RANDOM.normal(size=len(TIME)))
    assert found.remarks == ()
    assert found.rate == pytest.approx(100.0)
    assert found.missing_share == 0.0
    assert found.longest_gap == pytest.approx(0.01)


def test_absent_channel():
    with pytest.raises(InputError, match="no channel"):
        channel_quality(Recording({})["yaw_rate"])


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.full(len(TIME), np.nan), "every sample is missing"),
        (np.full(len(TIME), 0.25), "constant at 14.3239 °/s throughout"),
        (60.0 * np.sin(TIME), "leaves the plausible"),
        (np.clip(np.sin(TIME), -0.7, 0.7), "samples in a row at the upper end, 40.11 °/s"),
        (np.where(TIME % 10.0 < 1.0, np.nan, np.sin(TIME)), "10 % of the samples are missing"),
        (np.round(np.sin(TIME), 1), "coarse: 21 distinct values, 5.73 °/s apart"),
    ],
)
def test_remarks_on_values(values, expected):
    assert expected in remarks(values)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.full(len(TIME), 0.25), "constant at 14.3239 °/s throughout"),
        (np.clip(np.sin(TIME), -0.7, 0.7), "saturated"),
        (np.round(np.sin(TIME), 1), "coarse: 21 distinct values, 5.73 °/s apart"),
    ],
)
def test_rounding_residues_hide_nothing(values, expected):
    assert expected in remarks(values * (1.0 + 1e-15 * np.random.default_rng(2).standard_normal(len(TIME))))


def test_a_turn_that_rests_at_zero_is_not_saturated():
    assert "saturated" not in remarks(np.maximum(0.5 * np.sin(0.2 * TIME), 0.0))


def test_a_free_signal_is_not_saturated():
    assert "saturated" not in remarks(0.8 * np.sin(0.2 * TIME))


def test_a_gap_of_seconds():
    keep = (TIME < 20.0) | (TIME > 25.0)
    found = quality(np.sin(TIME)[keep], TIME[keep])
    assert found.longest_gap == pytest.approx(5.01, abs=0.02)
    assert any("longest gap lasts 5.0" in remark for remark in found.remarks)


@pytest.mark.parametrize(("lost", "told"), [(0.06, False), (0.2, True)])
def test_ten_lost_messages_are_a_gap(lost, told):
    keep = np.abs(TIME - 20.0) > 0.5 * lost
    assert ("longest gap" in remarks(np.sin(TIME)[keep], TIME[keep])) is told


def test_one_hertz_is_too_slow():
    time = np.arange(60.0)
    assert "1 Hz is too slow for a steering monitor" in remarks(np.sin(time), time)


def test_bursts_are_seen():
    time = 0.05 * np.floor(TIME / 0.05) + 1e-5 * (np.arange(len(TIME)) % 5)
    assert "arrive in bursts" in remarks(0.3 * np.sin(TIME) + 0.001 * RANDOM.normal(size=len(TIME)), time)


def test_no_samples():
    assert "holds no samples" in remarks(np.empty(0), np.empty(0))
    assert np.isnan(median_rate(np.empty(0)))


@pytest.mark.parametrize(("rate", "slow"), [(19.9, False), (20.0, False), (18.0, True)])
def test_a_rate_need_not_be_met_to_the_last_digit(rate, slow):
    time = np.arange(0.0, 60.0, 1.0 / rate)
    assert ("too slow" in remarks(np.sin(time), time)) is slow


def test_a_wheel_that_comes_to_rest_is_not_saturated():
    angle = 2.0 * np.sin(0.5 * TIME)
    peak = int(np.argmax(angle))
    wait = np.insert(angle, peak, np.full(200, angle[peak]))[: len(TIME)]
    assert "saturated" not in remarks(np.round(wait, 4))
    assert "saturated" in remarks(np.round(np.clip(angle, -2.0, 1.2), 4))


def test_a_unit_that_somebody_gave_is_not_guessed_again():
    degrees = Channel("yaw_rate", TIME, 60.0 * np.sin(TIME), "rad/s")
    remarks = " ".join(channel_quality(degrees).remarks)
    assert "check sensor, unit and factor" in remarks
    assert "looks like" not in remarks
    assumed = " ".join(channel_quality(degrees.noted("unit not given, taken as rad/s")).remarks)
    assert "looks like degrees: check the unit" in assumed


def test_remarks_have_the_units_of_the_tables():
    remarks = " ".join(channel_quality(Channel("yaw_rate", TIME, 60.0 * np.sin(TIME), "rad/s")).remarks)
    assert "°/s" in remarks
    assert "rad" not in remarks
    torque = " ".join(channel_quality(Channel("driver_torque", TIME, np.round(np.sin(TIME), 1), "N*m")).remarks)
    assert "0.1 N·m apart" in torque


def test_a_wheel_at_rest_that_is_read_in_coarse_steps_is_not_saturated():
    rest = -6.1 + 0.1 * np.maximum((np.arange(2500) - 2000) // 40, 0)
    assert "saturated" not in remarks(np.radians(rest), TIME[: len(rest)])


def test_a_wheel_at_rest_of_a_real_car_is_not_saturated_and_counts_do_not_look_like_degrees():
    folder = "dacia_lock_to_lock"
    recording = read(shared_data(folder, "candump.log"), dbc=shared_data(folder, "logan.dbc"))
    names = ("steering_wheel_angle", "steering_wheel_rate")
    found = {name: " ".join(channel_quality(recording[name]).remarks) for name in names}
    assert "saturated" not in found["steering_wheel_angle"]
    assert "looks like degrees" not in found["steering_wheel_rate"]
