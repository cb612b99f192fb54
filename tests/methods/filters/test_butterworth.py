import dataclasses
from typing import NamedTuple

import numpy as np
import pytest
from scipy import signal

from tierod.core.graph import scan
from tierod.methods.filters import Butterworth


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
