import math

import numpy as np
import pytest

from tierod.errors import InputError
from tierod.units import conversion, convert


@pytest.mark.parametrize(
    ("value", "unit", "to", "expected"),
    [
        (110.0, "kN/rad", "N/rad", 110e3),
        (180.0, "deg", "rad", math.pi),
        (36.0, "km/h", "m/s", 10.0),
        (1.0, "N*m*s/rad", "N*m*s", 1.0),
        (20.0, "degC", "kelvin", 293.15),
        (725.0, "count", "count", 725.0),
        (50.0, "%", "", 0.5),
    ],
)
def test_converts(value, unit, to, expected):
    assert convert(value, unit, to) == pytest.approx(expected, rel=1e-12)


def test_converts_arrays():
    np.testing.assert_allclose(convert(np.array([0.0, 90.0, np.nan]), "deg", "rad"), [0.0, math.pi / 2, np.nan])


@pytest.mark.parametrize(("unit", "to"), [("kg", "m"), ("count", "N*m"), ("count", ""), ("rad", "count")])
def test_refuses_another_kind(unit, to):
    with pytest.raises(InputError, match="cannot be converted"):
        conversion(unit, to)


@pytest.mark.parametrize("unit", ["furlongs_per_fortnite", "N*", "(("])
def test_names_a_unit_that_is_none(unit):
    with pytest.raises(InputError, match="not a unit"):
        conversion(unit, "m")
