"""Recordings: faults of channels are repaired or refused, slices and alignment keep gaps visible."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording, checked, checked_together


def channel(name="yaw_rate", time=(0.0, 1.0, 2.0), values=(1.0, 2.0, 3.0), unit="rad/s", **more) -> Channel:
    return Channel(name, np.array(time, dtype=float), np.array(values, dtype=float), unit, **more)


def recording(*channels: Channel) -> Recording:
    return Recording({one.name: one for one in channels})


def test_an_absent_channel_names_the_nearest():
    with pytest.raises(InputError, match="no channel 'yaw_rte'; did you mean 'yaw_rate'"):
        recording(channel())["yaw_rte"]


def test_a_recording_without_samples():
    with pytest.raises(InputError, match="holds no samples"):
        _ = recording(channel(time=(), values=())).span


def test_lengths_must_agree():
    with pytest.raises(InputError, match="as many time stamps as values"):
        checked(channel(time=(0.0, 1.0)))


def test_infinite_values_become_missing_with_a_note():
    fit = checked(channel(values=(1.0, np.inf, 3.0), note="raw"))
    assert np.isnan(fit.values[1])
    assert fit.note == "raw; 1 infinite values taken as missing"


def test_shared_stamps_stay_shared():
    time = np.array([0.0, 0.02, 0.01])
    a, b = checked_together([Channel("a", time, np.arange(3.0), ""), Channel("b", time, np.arange(3.0), "")])
    assert a.time is b.time
    assert b.values.tolist() == [0.0, 2.0, 1.0]


def test_with_channels_adds_replaces_and_checks():
    base = recording(channel())
    more = base.with_channels([channel("vehicle_speed", unit="m/s"), channel(values=(0.0, 0.0, 0.0))])
    assert more.names == ("yaw_rate", "vehicle_speed")
    assert more["yaw_rate"].values.tolist() == [0.0, 0.0, 0.0]
    assert base.names == ("yaw_rate",)
    with pytest.raises(InputError, match="jumps back"):
        base.with_channels([channel(time=(5.0, 0.0, 1.0))])


def test_warnings_gather_without_repetition():
    warned = recording(channel()).warned("a", "").warned("a", "b")
    assert warned.warnings == ("a", "b")


def test_slices_are_half_open():
    part = recording(channel()).slice(0.0, 2.0)
    assert part["yaw_rate"].time.tolist() == [0.0, 1.0]
    assert recording(channel()).slice(1.0)["yaw_rate"].time.tolist() == [1.0, 2.0]


@given(st.lists(st.floats(0.0, 100.0), min_size=1, max_size=30), st.floats(0.0, 100.0))
def test_two_slices_make_the_whole(times, cut):
    whole = recording(channel(time=sorted(times), values=range(len(times))))
    parts = [whole.slice(stop=cut)["yaw_rate"], whole.slice(cut)["yaw_rate"]]
    assert np.concatenate([part.values for part in parts]).tolist() == whole["yaw_rate"].values.tolist()


def test_retime_notes_what_was_done():
    sent = 0.01 * np.arange(500)
    burst = channel(time=0.04 * np.ceil(sent / 0.04 - 1e-9), values=np.arange(500.0))
    again = recording(burst).retime(0.01)["yaw_rate"]
    assert np.median(np.diff(again.time)) == pytest.approx(0.01)
    assert "time stamps regenerated, 10 ms apart" in again.note


def test_alignment_leaves_gaps_and_absent_signals_missing():
    time = np.concatenate((np.arange(0.0, 1.0, 0.01), np.arange(3.0, 4.0, 0.01)))
    aligned = recording(channel(time=time, values=np.ones(200))).align(["yaw_rate", "vehicle_speed"], 100.0)
    assert np.isnan(aligned.values[:, 1]).all()
    gap = (aligned.time > 1.11) & (aligned.time < 2.99)
    assert np.isnan(aligned.values[gap, 0]).all()
    assert np.isfinite(aligned.values[~gap & (aligned.time < 1.08), 0]).all()


def test_the_last_of_equal_stamps_counts():
    aligned = recording(channel(time=(0.0, 1.0, 1.0), values=(1.0, 2.0, 3.0))).align(["yaw_rate"], 1.0, maximum_age=0.5)
    assert aligned.values[:, 0].tolist() == [1.0, 3.0]


@pytest.mark.parametrize(("rate", "age"), [(0.0, 0.1), (-1.0, 0.1), (float("nan"), 0.1), (100.0, 0.0)])
def test_alignment_needs_positive_figures(rate, age):
    with pytest.raises(InputError, match="positive rate and maximum age"):
        recording(channel()).align(["yaw_rate"], rate, maximum_age=age)


def test_a_grid_over_a_clock_that_was_set_is_refused():
    time = np.array([0.0, 1.0, 1.7e9])
    with pytest.raises(InputError, match="from 0 s to 1.7e\\+09 s is too long: does a clock jump ahead"):
        Recording({"a": Channel("a", time, time, "")}).align(["a"], 100.0)


def test_a_grid_follows_the_samples_not_the_span():
    time = 10.0 * np.arange(10_000.0)
    slow = Recording({"a": Channel("a", time, time, "")})
    assert len(slow.align(["a"], 40.0).time) == 3_999_601
    with pytest.raises(InputError, match="from 0 s to 99990 s is too long.*count milliseconds"):
        slow.align(["a"], 50.0)


@pytest.mark.parametrize("method", ["hold", "linear"])
def test_stamps_that_channels_share_give_the_same_as_stamps_of_their_own(method):
    chance = np.random.default_rng(3)
    time = np.cumsum(chance.choice([0.01, 0.02, 0.5], 300))
    one, other = (channel(name, time, chance.normal(size=300)) for name in ("yaw_rate", "vehicle_speed"))
    shared = recording(*(Channel(each.name, one.time, each.values, each.unit) for each in (one, other)))
    own = recording(one, channel(other.name, time, other.values))
    for of in (lambda each: each, lambda each: each.slice(1.0, 6.0)):
        first, second = (of(each).align(("yaw_rate", "vehicle_speed"), 77.0, method) for each in (shared, own))
        np.testing.assert_array_equal(first.values, second.values)
        assert np.isnan(first.values).any()
    sliced = shared.slice(1.0, 6.0)
    assert sliced["yaw_rate"].time is sliced["vehicle_speed"].time


@given(
    st.sampled_from([50.0, 100.0, 1000.0]), st.sampled_from([20.0, 50.0, 100.0]), st.floats(-0.02, 0.3),
    st.sampled_from(["as they are", "jittered", "one lost", "twice the same"]),
)  # fmt: skip
def test_regular_clocks_align_as_a_search_for_every_time_does(rate, grid_rate, start, stamps):
    time = np.arange(round(4.0 * rate)) / rate
    if stamps == "jittered":
        time = np.sort(time + np.random.default_rng(1).uniform(0.0, 2.0 / rate, len(time)))
    elif stamps == "one lost":
        time = np.delete(time, len(time) // 2)
    elif stamps == "twice the same":
        time[len(time) // 3] = time[len(time) // 3 - 1]
    values = np.arange(len(time), dtype=float)
    aligned = recording(channel(time=time, values=values)).align(
        ["yaw_rate"], grid_rate, maximum_age=0.1, start=start, stop=3.5
    )
    for at, found in zip(aligned.time, aligned.columns["yaw_rate"], strict=True):
        before = np.flatnonzero(time <= at + 1e-6)
        held = len(before) and at - time[before[-1]] <= 0.1 + 1e-6
        assert found == values[before[-1]] if held else np.isnan(found)
    assert aligned.there["yaw_rate"].tolist() == np.isfinite(aligned.values[:, 0]).tolist()
