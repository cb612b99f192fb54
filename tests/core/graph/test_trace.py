"""What cannot be traced is refused with the cure."""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pytest

from tierod.core.block import Ring
from tierod.core.errors import CompileError, TraceError
from tierod.core.graph import jacobian, maths, scan, trace


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
        (lambda s, x: (s, One(int(x))), "takes only numbers"),
        (lambda s, x: ((s[0], x), One(x)), "another shape"),
        (lambda s, x: (s, One(float(x))), "NaN constant"),
    ],
)
def test_untraceable_code_is_refused_with_the_cure(function, cure):
    with pytest.raises(TraceError, match=cure):
        trace(Applied(function))


def test_a_delay_line_must_be_pushed():
    with pytest.raises(TraceError, match="without a push"):
        trace(Applied(lambda s, x: (s, One(s[0].oldest)), Ring(3)))


@pytest.mark.parametrize("size", [0, -2, 3.0])
def test_a_delay_line_holds_at_least_one_sample(size):
    with pytest.raises(TraceError, match=f"holds {size} samples; give it a size of at least 1"):
        trace(Applied(_smooth, Ring(size)))


def test_a_field_that_can_change_is_refused():
    with pytest.raises(TraceError, match=r"can change \(unhashable type: 'list'\); give a tuple"):
        trace(Applied(_smooth, [1.0, 2.0]))


def _scaled_block(factor):
    @dataclass(frozen=True)
    class Scaled:
        Sample = One

        def init(self):
            return ()

        def step(self, state, sample):
            return (), One(factor * sample.value)

    return Scaled()


def test_a_class_written_anew_under_an_old_name_is_traced_anew():
    values = [scan(_scaled_block(factor), [1.0]).values.item() for factor in (2.0, 3.0)]
    assert values == [2.0, 3.0]


def test_jacobian_of_numbers_and_structural_zeros():
    rows = jacobian(lambda x: (x[0] * x[1], maths.sin(x[1]), 3.0 * x[2]), (2.0, 0.5, 1.0))
    np.testing.assert_allclose(rows, [[0.5, 2.0, 0.0], [0.0, math.cos(0.5), 0.0], [0.0, 0.0, 3.0]], rtol=1e-15)
    assert all(type(entry) is float for row in rows for entry in row)


def test_without_a_compiler_blocks_run_on_the_virtual_machine(monkeypatch):
    monkeypatch.setattr("tierod.core.graph.kernel.compiler", lambda: None)
    monkeypatch.setattr("tierod.core.graph.compiler.compiler", lambda: None)
    block = Applied(_smooth, 0.5)
    assert np.isfinite(scan(block, np.ones(10)).values).all()
    with pytest.raises(CompileError, match="no C compiler was found"):
        scan(block, np.ones(10), engine="compiled")


def _smooth(state, value):
    level = 0.5 * state[0] + 0.25 * value
    return (level,), One(level)
