"""Pieces of any length become slices of equal length, with nothing lost."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.readers.content import Allowance
from tierod.io.readers.slices import slices
from tierod.io.readers.source import Piece


def regrouped(pieces, seconds: float, *lanes) -> list[dict[str, Channel]]:
    """The slices of one lane or of several, as channels by name."""
    every = [(Piece(piece) for piece in lane) for lane in (pieces, *lanes)]
    found = slices(every, seconds, Allowance("some file", 0))
    return [{channel.name: channel for channel in part.channels} for part in found]


def piece(start: float, stop: float) -> list[Channel]:
    fast, slow = np.arange(start, stop, 0.5), np.arange(start, stop, 2.0)
    return [Channel("fast", fast, fast, ""), Channel("slow", slow, slow, "")]


@given(st.lists(st.integers(1, 40), min_size=1, max_size=8), st.sampled_from([1.0, 3.0, 10.0, 1000.0]))
def test_nothing_is_lost_and_slices_have_their_length(lengths, seconds):
    edges = np.cumsum([0, *lengths]).astype(float)
    pieces = [piece(a, b) for a, b in itertools.pairwise(edges)]
    slices = list(regrouped(pieces, seconds))
    for name, place in (("fast", 0), ("slow", 1)):
        whole = np.concatenate([part[place].time for part in pieces])
        assert np.array_equal(np.concatenate([part[name].time for part in slices]), whole)
    for part in slices:
        assert (part["fast"].time // seconds == part["fast"].time[0] // seconds).all()


def test_channels_with_one_clock_keep_it():
    time = np.arange(10.0)
    for part in regrouped([[Channel("a", time, time, ""), Channel("b", time, time, "")]], 4.0):
        assert part["a"].time is part["b"].time or np.shares_memory(part["a"].time, part["b"].time)


def test_a_long_gap_leaves_slices_out():
    slices = list(regrouped([piece(0.0, 4.0), piece(100.0, 104.0)], 10.0))
    assert [part["fast"].time[0] for part in slices] == [0.0, 100.0]


def test_an_empty_piece_does_no_harm():
    empty = [Channel("fast", np.empty(0), np.empty(0), ""), Channel("slow", np.empty(0), np.empty(0), "")]
    assert len(list(regrouped([empty, piece(0.0, 4.0), empty], 2.0))) == 2


def test_time_must_go_on():
    with pytest.raises(InputError, match="jumps back"):
        list(regrouped([piece(10.0, 20.0), piece(0.0, 5.0)], 5.0))


def test_samples_that_come_late_over_the_edge_of_a_piece_are_put_in_order():
    time = np.arange(0.0, 40.0, 0.1)
    late = time.copy()
    late[[199, 200]] = late[[200, 199]]
    pieces = [[Channel(name, part, 2.0 * part, "") for name in ("a", "b")] for part in np.split(late, 2)]
    slices = list(regrouped(pieces, 20.0))
    for name in ("a", "b"):
        assert np.array_equal(np.concatenate([part[name].time for part in slices]), time)
        assert np.array_equal(np.concatenate([part[name].values for part in slices]), 2.0 * time)
    assert any("1 samples that arrived late put in order" in part["a"].note for part in slices)
    assert all(part["a"].time is part["b"].time or np.shares_memory(part["a"].time, part["b"].time) for part in slices)


def test_a_late_sample_may_belong_before_the_edge_of_a_slice():
    first, second = np.array([0.0, 5.0, 10.3]), np.array([9.9, 10.4, 15.0])
    slices = list(regrouped([[Channel("a", part, part, "")] for part in (first, second)], 10.0))
    assert [part["a"].time.tolist() for part in slices] == [[0.0, 5.0, 9.9], [10.3, 10.4, 15.0]]


@pytest.mark.parametrize("leap", [1.7e9, 1e18, 1e300])
def test_a_clock_that_leaps_ahead_costs_no_time(leap):
    later = leap + 600.0 * np.arange(3.0)
    slices = list(
        regrouped([[Channel("a", np.array([0.0, 1.0]), np.zeros(2), "")], [Channel("a", later, later, "")]], 5.0)
    )
    assert np.array_equal(np.concatenate([part["a"].time for part in slices]), np.concatenate(([0.0, 1.0], later)))


def test_sparse_samples_are_not_slices_of_their_own():
    time = np.concatenate([np.arange(0.0, 1200.0, 0.5), 700.0 * np.arange(2.0, 2002.0)])
    for cuts in (1, 7):
        parts = [[Channel("a", part, part, "")] for part in np.array_split(time, cuts)]
        slices = list(regrouped(parts, 600.0))
        assert 30 < len(slices) < 40
        assert max(len(part["a"].time) for part in slices) == 1200
        assert np.array_equal(np.concatenate([part["a"].time for part in slices]), time)
