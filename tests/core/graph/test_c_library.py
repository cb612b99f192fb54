"""The functions that kernels do not take from the C library."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.graph import batch, maths, scan


class Value(NamedTuple):
    value: float


@dataclass(frozen=True)
class Exponential:
    """exp of each sample."""

    Sample = Value

    def init(self):
        return ()

    def step(self, state, sample):
        return state, Value(maths.exp(sample.value))


RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("span", [1e-300, 1e-12, 1e-3, 0.5, 5.0, 100.0, 706.0])
def test_exp_is_within_two_units_in_the_last_place(span):
    arguments = RANDOM.uniform(-span, span, 20_000)
    ours, exact = scan(Exponential(), arguments)["value"], np.exp(arguments)
    assert np.max(np.abs(ours - exact) / np.spacing(exact)) <= 2.0


def test_exp_at_the_ends_of_its_range():
    arguments = np.array([0.0, -0.0, 709.7, 709.8, 1e6, np.inf, -707.5, -1e6, -np.inf, np.nan])
    ours = scan(Exponential(), arguments)["value"]
    np.testing.assert_allclose(ours[:3], np.exp(arguments[:3]), rtol=1e-15)
    np.testing.assert_array_equal(ours[3:], [np.inf, np.inf, np.inf, 0.0, 0.0, 0.0, np.nan])


def test_exp_in_lanes_is_the_same_to_the_last_bit():
    arguments = RANDOM.uniform(-800.0, 800.0, 5_000)
    arguments[::50] = np.nan
    for lane in batch(Exponential(), [arguments] * 16):
        np.testing.assert_array_equal(lane["value"], scan(Exponential(), arguments)["value"])
