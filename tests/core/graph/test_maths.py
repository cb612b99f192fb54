"""Floats behave as compiled code does: IEEE results in place of exceptions and warnings."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.graph import maths


class Complex(NamedTuple):
    real: float
    imaginary: float


@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        (maths.arcsin, (2.0,), math.nan),
        (maths.arcsin, (0.5,), math.asin(0.5)),
        (maths.power, (-8.0, 1.0 / 3.0), math.nan),
        (maths.power, (0.0, -1.0), math.inf),
        (maths.power, (1e200, 2.0), math.inf),
        (maths.power, (2, -1), 0.5),
        (maths.sqrt, (-1.0,), math.nan),
        (maths.log, (0.0,), -math.inf),
        (maths.exp, (1e4,), math.inf),
        (maths.tan, (math.inf,), math.nan),
        (maths.floor, (math.nan,), math.nan),
        (maths.sign, (math.nan,), math.nan),
        (maths.minimum, (1.0, math.nan), 1.0),
        (maths.maximum, (math.nan, 1.0), math.nan),
        (maths.greatest_of, (2.0, 5.0, 3.0), 5.0),
        (maths.greatest_of, (-7.0,), -7.0),
        (maths.present, (math.inf,), 0.0),
        (maths.negated, (math.nan,), 0.0),
        (maths.where, (2.0, 3.0, math.nan), 3.0),
    ],
)
def test_floats_and_arrays_follow_ieee(function, arguments, expected):
    np.testing.assert_equal(float(function(*arguments)), expected)
    with np.errstate(all="ignore"):
        arrays = function(*(np.array([float(value)]) for value in arguments))
    np.testing.assert_allclose(arrays.astype(float), [expected], rtol=1e-15)


def test_one_of_two_trees_is_selected_whole():
    taken, otherwise = Complex(1.0, 2.0), Complex(3.0, math.nan)
    assert maths.select(1.0, (taken, 5.0), (otherwise, 6.0)) == (taken, 5.0)
    assert maths.select(0.0, (otherwise, 5.0), (taken, 6.0)) == (taken, 6.0)
    assert maths.select(0.0, 5.0, 6.0) == 6.0
