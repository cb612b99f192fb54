"""What cannot be traced is refused with the cure; what a block does, and not its names, decides its digest."""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from tierod.core.block import Ring, Scalar, tuning
from tierod.core.errors import TraceError
from tierod.core.graph import jacobian, maths, trace
from tierod.core.graph.analysis import graph_digest


class One(NamedTuple):
    value: float


@dataclass(frozen=True)
class Applied:
    """A block that applies a function to its sample and state."""

    function: Any = field()
    start: Any = 0.0
    Sample = One

    def init(self):
        return (self.start,)

    def step(self, state, sample):
        return self.function(state, sample.value)


@pytest.mark.parametrize(
    ("function", "cure"),
    [
        (lambda s, x: ((x if x > 0 else s[0],), One(x)), "where, both, either"),
        (lambda s, x: (s, One(max(x, 1.0))), "minimum or maximum"),
        (lambda s, x: (s, One(x > 0 and x < 1)), "chained comparison"),
        (lambda s, x: (s, One(math.sin(x))), "NaN constant"),
        (lambda s, x: ((s[0], x), One(x)), "another shape"),
    ],
)
def test_untraceable_code_is_refused_with_the_cure(function, cure):
    with pytest.raises(TraceError, match=cure):
        trace(Applied(function))


def test_a_delay_line_must_be_pushed():
    with pytest.raises(TraceError, match="without a push"):
        trace(Applied(lambda s, x: (s, One(s[0].oldest)), Ring(3)))


def test_jacobian_of_numbers_and_structural_zeros():
    rows = jacobian(lambda x: (x[0] * x[1], maths.sin(x[1]), 3.0 * x[2]), (2.0, 0.5, 1.0))
    np.testing.assert_allclose(rows, [[0.5, 2.0, 0.0], [0.0, math.cos(0.5), 0.0], [0.0, 0.0, 3.0]], rtol=1e-15)
    assert all(type(entry) is float for row in rows for entry in row)


class Gains(NamedTuple):
    """Of two channels."""

    first: Annotated[float, "1/s"]
    second: Any


@dataclass(frozen=True)
class Inner:
    """A part."""

    limit: float | None = None
    bare: Any = 3
    count: int = 2


@dataclass(frozen=True)
class Outer:
    """A whole."""

    gain: Annotated[float, "N*m"]
    taps: tuple[float, ...] = (0.5,)
    pair: tuple[float, int] = (0.5, 4)
    gains: Gains = field(default_factory=lambda: Gains(1.0, 1))
    inner: Inner = Inner()
    flag: bool = True


def test_a_whole_number_in_a_field_of_floats_is_tuning():
    whole = Outer(2, (1, 2, 3), (1, 4), Gains(5, 1), Inner(6))
    assert list(tuning(whole)) == [
        ("gain", 2.0),
        ("taps.0", 1.0),
        ("taps.1", 2.0),
        ("taps.2", 3.0),
        ("pair.0", 1.0),
        ("gains.first", 5.0),
        ("inner.limit", 6.0),
    ]
    assert all(type(value) is float for _, value in tuning(whole))


class Sample(NamedTuple):
    torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class Smooth:
    gain: Annotated[float, ""] = 0.1
    Sample = Sample

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Scalar]:
        value = state + self.gain * (sample.torque - state)
        return value, value


@dataclass(frozen=True)
class Other(Smooth):
    """With a constant in its equation."""

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Scalar]:
        value = state + self.gain * (sample.torque - 1.0001 * state)
        return value, value


def test_a_threshold_and_a_constant_of_an_equation_count():
    digests = {
        graph_digest(each) for each in (Smooth(), replace(Smooth(), gain=0.11), Other(), replace(Other(), gain=0.2))
    }
    assert len(digests) == 4
    assert graph_digest(Smooth(), Other()) != graph_digest(Other(), Smooth())


@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        (maths.arcsin, (2.0,), math.nan),
        (maths.power, (-8.0, 1.0 / 3.0), math.nan),
        (maths.power, (0.0, -1.0), math.inf),
        (maths.sqrt, (-1.0,), math.nan),
        (maths.log, (0.0,), -math.inf),
        (maths.exp, (1e4,), math.inf),
        (maths.sign, (math.nan,), math.nan),
        (maths.minimum, (1.0, math.nan), 1.0),
        (maths.maximum, (math.nan, 1.0), math.nan),
        (maths.greatest_of, (2.0, 5.0, 3.0), 5.0),
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
