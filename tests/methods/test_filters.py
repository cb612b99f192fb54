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
from tierod.core.graph import scan
from tierod.methods.filters import Butterworth, Differentiator, FirstOrderLowPass, InputHold, JumpGate


class Signals(NamedTuple):
    angle: Annotated[float, "rad"]
    torque: Annotated[float, "N*m"]


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


def test_first_order_low_pass_follows_its_time_constant():
    step = np.vstack([np.zeros((1, 2)), np.ones((200, 2))])
    result = scan(BLOCKS["first order"], step)["angle"]
    time = np.arange(1, 201) * 0.01
    np.testing.assert_allclose(result[1:], 1.0 - np.exp(-time / 0.05), rtol=1e-9)


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
