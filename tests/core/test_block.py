import dataclasses
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from tierod.core.block import Ring, leaves, structure, tuning, values_of, with_tuning
from tierod.core.graph import batch, scan
from tierod.methods.detectors import Cusum


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


def test_it_shapes_the_graph_no_more_than_the_float_does():
    assert structure(Outer(2, (1,))) == structure(Outer(2.0, (1.0,)))
    assert structure(Outer(2)) != structure(dataclasses.replace(Outer(2), flag=False))


@pytest.mark.parametrize("change", [{"count": 3}, {"bare": 4}, {"limit": True}, {"limit": 1.0}])
def test_what_is_no_float_stays_structure(change):
    assert structure(Inner(**change)) != structure(Inner())


@pytest.mark.parametrize("number", [2, np.int64(2), np.float32(2.0), Fraction(2)])
def test_every_real_number_is_taken(number):
    assert next(tuning(Outer(number))) == ("gain", 2.0)


def test_new_values_go_where_the_old_ones_were():
    block = with_tuning(Outer(2, (1, 2), gains=Gains(5, 1), inner=Inner(6)), "abcdef")
    assert (block.gain, block.taps, block.pair, block.gains) == ("a", ("b", "c"), ("d", 4), ("e", 1))
    assert block.inner == Inner("f")


def test_calibrations_in_whole_numbers_share_a_batch_with_floats():
    values = np.array([0.0, 3.0, 3.0, 0.0])
    whole, parts = Cusum(1, 4, 20), Cusum(0.5, 4.5, 20.0)
    together = batch([whole, parts], [values, values])
    for block, result in zip((whole, parts), together, strict=True):
        np.testing.assert_array_equal(result.values, scan(block, values).values)
    assert together[0]["alarm"][2] == 1.0


def test_where_annotations_cannot_be_read_numbers_stay_as_written():
    class Local:
        """Known to this function alone."""

    @dataclass(frozen=True)
    class Holder:
        local: "Local"
        gain: "float"

    assert list(tuning(Holder(Local(), 1.0))) == [("gain", 1.0)]
    assert list(tuning(Holder(Local(), 1))) == []


@pytest.mark.parametrize(
    "tree", [1.0, (), (1.0, (2.0, ())), Ring(3), (Ring(2, 0.5), ((1.0, Ring(1)), 2.0)), Cusum(1.0, 4.0, 20.0).init()]
)
def test_values_of_a_tree_are_its_leaves_without_their_paths(tree):
    assert values_of(tree) == [leaf for _, leaf in leaves(tree)]
