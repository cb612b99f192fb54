"""Delay lines that remember the same numbers are one in C, and numbers of one kind an array."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, run
from tierod.core.block import Ring
from tierod.export.subject import members, subject_of_block
from tierod.export.vectors import random_inputs

DELAYS = ((2, 5, 9), (2, 5, 7))


class Late(NamedTuple):
    """Inputs some steps ago."""

    values: tuple


@dataclass(frozen=True)
class ManyDelays:
    """Several delays of two inputs, and one line whose first numbers are others."""

    gain: Annotated[float, ""] = 2.0
    Sample = Pair

    class State(NamedTuple):
        past: tuple
        own: Ring

    def init(self):
        return self.State(tuple(tuple(Ring(delay, 0.5) for delay in row) for row in DELAYS), Ring(4, -1.0))

    def step(self, state, sample):
        given = (self.gain * sample.a, sample.b)
        past = tuple(tuple(line.push(x) for line in row) for row, x in zip(state.past, given, strict=True))
        values = (*(line.oldest for row in state.past for line in row), state.own.oldest)
        return self.State(past, state.own.push(given[0])), Late(values)


@needs_gcc
def test_delays_of_one_signal_share_a_line_and_equal_scan_to_the_last_bit(tmp_path):
    subject = subject_of_block("late", ManyDelays(), 100.0, "Many delays")
    inputs = random_inputs(subject, 60)
    face = exported(subject, tmp_path, inputs=inputs, precision="double")
    assert np.array_equal(run(face, tmp_path, inputs), reference(subject, inputs), equal_nan=True)
    header = (tmp_path / "tierod_late.h").read_text()
    assert "tierod_late_real_t past[2][9];" in header
    assert "tierod_late_real_t own[4];" in header
    assert header.count("_head;") == 2


def test_numbers_within_a_path_are_places_of_an_array():
    assert [each.declarator for each in members(["a.0.x", "a.0.y", "a.1.x", "a.1.y"])] == ["a_x[2]", "a_y[2]"]
    assert [each.declarator for each in members(["a.0.d.0", "a.0.d.1", "a.1.d.0"])] == ["a_d[3]"]
    assert [each.declarator for each in members(["a.0.x", "a.2.x"])] == ["a_0_x", "a_2_x"]
