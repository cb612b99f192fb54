"""What all filters over several signals promise, and the short ones themselves."""

from __future__ import annotations

import dataclasses
import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from example_models import with_gaps
from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.filters import Butterworth, Differentiator, FirstOrderLowPass, InputHold, JumpGate


class Signals(NamedTuple):
    angle: Annotated[float, "rad"]
    torque: Annotated[float, "N*m"]


class Empty(NamedTuple):
    pass


COMMON = {"signals": Signals, "sample_time": 0.01, "maximum_gap": 0.05}
BLOCKS = {
    "butterworth": Butterworth(**COMMON, cutoff=5.0),
    "fourth order": Butterworth(**COMMON, cutoff=5.0, order=4),
    "first order": FirstOrderLowPass(**COMMON, time_constant=0.05),
    "derivative": Differentiator(**COMMON, time_constant=0.05),
    "hold": InputHold(**COMMON),
    "jumps": JumpGate(**COMMON, deviation_per_second=30.0),
}
each = pytest.mark.parametrize("block", BLOCKS.values(), ids=BLOCKS)
GAP = 5  # samples that maximum_gap bridges


@each
@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000))
def test_no_pattern_of_gaps_reaches_the_memory_and_the_output_is_missing_only_where_it_must_be(block, seed):
    rng = np.random.default_rng(seed)
    values = with_gaps(rng, rng.normal(size=(60, 2)), rng.choice([0.2, 0.9]))
    result = scan(block, values)
    assert np.isfinite(result.values[np.isfinite(values)]).all()
    for column in range(2):
        age = math.inf
        for value, output in zip(values[:, column], result.values[:, column], strict=True):
            age = 0 if np.isfinite(value) else age + 1
            assert np.isfinite(output) == (age <= GAP)
    memory = [v for v in result.state.values if not math.isinf(v)]
    assert np.isfinite(memory).all()


@each
def test_it_starts_without_a_transient(block):
    result = scan(block, np.full((200, 2), 7.0))
    np.testing.assert_allclose(result.values, 0.0 if isinstance(block, Differentiator) else 7.0, atol=1e-9)


@each
def test_it_starts_anew_after_a_long_gap(block):
    values = np.vstack([np.full((50, 2), 7.0), np.full((GAP + 1, 2), np.nan), np.full((50, 2), -3.0)])
    result = scan(block, values).values
    np.testing.assert_allclose(result[50 + GAP + 1 :], 0.0 if isinstance(block, Differentiator) else -3.0, atol=1e-9)


@each
def test_a_short_gap_is_bridged_with_the_last_value(block):
    rng = np.random.default_rng(3)
    values = rng.normal(size=(60, 2)).cumsum(axis=0)
    bridged = values.copy()
    bridged[20 : 20 + GAP] = values[19]
    values[20 : 20 + GAP] = np.nan
    np.testing.assert_array_equal(scan(block, values).values, scan(block, bridged).values)


@each
def test_every_signal_is_treated_alike_and_alone(block):
    rng = np.random.default_rng(5)
    signal = rng.normal(size=80)
    both = scan(block, np.column_stack([signal, signal])).values
    np.testing.assert_array_equal(both[:, 0], both[:, 1])
    holed = np.column_stack([signal, np.where(np.arange(80) < 40, np.nan, signal)])
    np.testing.assert_array_equal(scan(block, holed).values[:, 0], both[:, 0])


def test_first_order_low_pass_follows_its_time_constant():
    step = np.vstack([np.zeros((1, 2)), np.ones((200, 2))])
    result = scan(BLOCKS["first order"], step)["angle"]
    time = np.arange(1, 201) * 0.01
    np.testing.assert_allclose(result[1:], 1.0 - np.exp(-time / 0.05), rtol=1e-9)


def test_derivative_of_a_ramp_is_its_slope():
    ramp = np.outer(np.arange(200) * 0.01, [3.0, -2.0])
    result = scan(BLOCKS["derivative"], ramp)
    np.testing.assert_allclose(result.values[-1], [3.0, -2.0], rtol=1e-9)
    assert result["angle"][0] == 0.0
    assert units(BLOCKS["derivative"].Output) == ["(rad)/s", "(N*m)/s"]
    assert BLOCKS["derivative"].Output._fields == Signals._fields


def test_a_leap_is_held_and_a_step_that_stays_passes_once_the_signal_may_have_got_there():
    angle = np.concatenate([0.002 * np.arange(50), np.full(50, 1.0)])
    angle[20] = 2.0
    gate = dataclasses.replace(BLOCKS["jumps"], deviation_per_second=1.0, gate=9.0)
    result = scan(gate, np.column_stack([angle, angle]))["angle"]
    assert result[20] == angle[19]
    np.testing.assert_array_equal(np.delete(result[:50], 20), np.delete(angle[:50], 20))
    way = 1.0 - angle[49]
    late = math.ceil(way / (3.0 * 0.01)) - 1  # samples until three deviations reach as far
    assert (result[50 : 50 + late] == angle[49]).all()
    assert (result[50 + late :] == 1.0).all()


def test_a_slow_signal_that_is_held_between_its_values_is_not_taken_for_a_leaping_one():
    angle = np.repeat(0.002 * 5.0 * np.arange(20), 5)
    samples = np.column_stack([angle, angle])
    gate = dataclasses.replace(BLOCKS["jumps"], deviation_per_second=0.1, gate=9.0)
    assert (scan(gate, samples)["angle"] != angle).any()
    np.testing.assert_array_equal(scan(dataclasses.replace(gate, interval=0.05), samples)["angle"], angle)


@pytest.mark.parametrize(
    ("block", "changes", "words"),
    [
        ("butterworth", {"cutoff": 50.0}, "less than 50.0 Hz"),
        ("butterworth", {"cutoff": 0.0}, "cutoff is 0.0"),
        ("butterworth", {"order": 3}, "even number"),
        ("first order", {"time_constant": 0.0}, "time_constant is 0.0"),
        ("derivative", {"time_constant": math.nan}, "time_constant is nan"),
        ("jumps", {"interval": -1.0}, "interval is -1.0"),
        ("jumps", {"deviation_per_second": 0.0}, "deviation_per_second is 0.0"),
        ("hold", {"sample_time": 0.0}, "sample_time is 0.0"),
        ("hold", {"maximum_gap": -1.0}, "maximum_gap is -1.0"),
        ("hold", {"signals": Empty}, "at least one signal"),
    ],
)
def test_wrong_tuning_is_refused(block, changes, words):
    with pytest.raises(ParameterError, match=words):
        dataclasses.replace(BLOCKS[block], **changes)


class One(NamedTuple):
    value: float


BLOCK = Butterworth(One, 0.01, 0.1, 5.0)


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("cutoff", [0.3, 5.0, 45.0])
def test_same_numbers_as_scipy(order, cutoff):
    block = dataclasses.replace(BLOCK, cutoff=cutoff, order=order)
    values = np.random.default_rng(0).normal(size=2000).cumsum()
    sos = signal.butter(order, cutoff, fs=100.0, output="sos")
    expected = signal.sosfilt(sos, values, zi=signal.sosfilt_zi(sos) * values[0])[0]
    np.testing.assert_allclose(scan(block, values)["value"], expected, rtol=1e-7, atol=1e-8)


def test_gain_at_the_cutoff_is_minus_three_decibel():
    time = np.arange(4000) * 0.01
    result = scan(BLOCK, np.sin(2.0 * np.pi * 5.0 * time))["value"][2000:]
    assert np.sqrt(2.0 * np.mean(result**2)) == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_delay_at_low_frequency_is_as_documented():
    ramp = np.arange(1000) * 0.01
    lag = ramp[-1] - scan(BLOCK, ramp)["value"][-1]
    assert lag == pytest.approx(0.225 / 5.0, rel=0.01)
