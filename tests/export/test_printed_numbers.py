"""Numbers that are easily printed wrong: first states, zeros with a sign, values by a tuned number, negative times."""

import functools
import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, rounded, run, worst_share
from tierod.core.block import Ring
from tierod.core.errors import ParameterError
from tierod.core.graph import maths
from tierod.core.graph import operations as branches
from tierod.core.graph.operations import Builder, is_constant
from tierod.export import c_source
from tierod.export.cut_printer import CutPrinter
from tierod.export.subject import subject_of_block
from tierod.export.vectors import random_inputs


class Two(NamedTuple):
    """What the blocks state."""

    x: float
    y: float


def same_as_scan(block, folder, count=400, **options):
    """Whether the C of a block gives what `scan` gives, zeros with their signs, in double precision."""
    subject = subject_of_block("block", block, 100.0)
    inputs = rounded(random_inputs(subject, count))
    face = exported(subject, folder, inputs, precision="double", **options)
    found, wanted = run(face, folder, inputs), reference(subject, inputs)
    assert np.array_equal(np.signbit(found), np.signbit(wanted))
    return np.array_equal(found, wanted, equal_nan=True)


@dataclass(frozen=True)
class TunedChoice:
    """One of many values by a number of the tuning."""

    number: Annotated[float, ""] = 3.0
    gain: Annotated[float, ""] = 0.5
    Sample = Pair

    def init(self):
        return 0.0

    def step(self, state, sample):
        value = sample.a
        for k in range(1, 10):
            value = maths.where(self.number == float(k), sample.b + float(k), value)
        return self.gain * value, Two(value, state + self.gain * sample.a)


@needs_gcc
@pytest.mark.parametrize("number", [3.0, 9.0, 0.0, 10.0, 2.5])
def test_a_value_by_a_tuned_number_leaves_other_constants_where_they_are(tmp_path, number):
    assert same_as_scan(TunedChoice(number), tmp_path)


@dataclass(frozen=True)
class Lines:
    """Delay lines that begin with parameters."""

    first: Annotated[float, ""] = 0.3
    slope: Annotated[float, ""] = 2.0
    sizes: tuple[int, int, int] = (3, 1, 5)
    Sample = Pair

    class State(NamedTuple):
        one: Ring
        two: Ring
        three: Ring

    def init(self):
        one, two, three = self.sizes
        return self.State(Ring(one, self.first), Ring(two, self.first * self.slope + 1.0), Ring(three, math.nan))

    def step(self, state, sample):
        after = self.State(state.one.push(sample.a), state.two.push(sample.b), state.three.push(sample.a))
        return after, Two(state.one.oldest + state.two.oldest, state.three.oldest)


@needs_gcc
@pytest.mark.parametrize("sizes", [(3, 1, 5), (2, 70_000, 65_535)])
def test_delay_lines_begin_with_what_init_gives(tmp_path, sizes):
    assert same_as_scan(Lines(sizes=sizes), tmp_path)


@dataclass(frozen=True)
class NegativeZero:
    """A state that begins with a negative zero, and one that begins with a parameter."""

    start: Annotated[float, ""] = 0.3
    Sample = Pair

    def init(self):
        return (-0.0, self.start)

    def step(self, state, sample):
        zero, level = state
        return (maths.where(sample.a > 1e3, sample.a, zero), 0.5 * (level + sample.b)), Two(1.0 / zero, level)


@needs_gcc
def test_a_first_state_keeps_the_sign_of_its_zero_and_follows_the_parameters(tmp_path):
    assert same_as_scan(NegativeZero(), tmp_path)
    assert "p->start" in (tmp_path / "tierod_block.c").read_text()


def test_a_zero_and_a_negative_zero_are_two_constants():
    builder = Builder()
    numbers = [builder.add("constant", (), value) for value in (0.0, -0.0, 0.0)]
    assert numbers == [0, 1, 0]
    assert [is_constant(each, 0.0) for each in builder.operations] == [True, False]


@dataclass(frozen=True)
class Counted:
    """A counter that is compared as a time, with any sign."""

    time: Annotated[float, "s"] = 0.01
    longest: Annotated[float, "s"] = 0.25
    Sample = Pair

    def init(self):
        return math.inf

    def step(self, state, sample):
        count = maths.where(sample.a > 0.5, 0.0, state + 1.0)
        return count, Two(maths.where((count - 0.5) * self.time < self.longest, sample.b, -1.0), count)


@needs_gcc
@pytest.mark.parametrize(("time", "longest"), [(-0.01, -0.25), (-0.5, 0.25), (0.0, 0.25), (0.01, -0.004), (0.1, 0.25)])
def test_a_counted_time_of_any_sign_is_compared_as_scan_compares(tmp_path, time, longest):
    assert same_as_scan(Counted(time, longest), tmp_path)


@dataclass(frozen=True)
class CountedByConstants:
    """A counter that is compared as a time, with nothing tuned."""

    Sample = Pair

    def init(self):
        return math.inf

    def step(self, state, sample):
        count = maths.where(sample.a > 0.5, 0.0, state + 1.0)
        return count, Two(maths.where((count - 0.5) * 0.01 < 0.25, sample.b, -1.0), count)


@needs_gcc
def test_what_follows_from_constants_is_worked_out_without_a_warning(tmp_path):
    assert same_as_scan(CountedByConstants(), tmp_path)
    subject = subject_of_block("block", CountedByConstants(), 100.0)
    run(exported(subject, tmp_path, precision="single"), tmp_path, random_inputs(subject, 10))


@dataclass(frozen=True)
class Since:
    """A clock in a block without parameters."""

    Sample = Pair

    def init(self):
        return 0.0

    def step(self, state, sample):
        time = maths.where(sample.a > 0.5, 0.0, state + 0.01)
        return time, Two(time, maths.where(time > 0.505, 1.0, 0.0))


@needs_gcc
def test_a_clock_counts_without_parameters_too(tmp_path):
    subject = subject_of_block("since", Since(), 100.0)
    inputs = rounded(random_inputs(subject, 400))
    face = exported(subject, tmp_path, inputs, precision="single")
    assert face.counted
    wanted = reference(subject, inputs)
    assert np.ptp(wanted[:, 1]) == 1.0
    assert worst_share(run(face, tmp_path, inputs), wanted).max() < 1e-6


@dataclass(frozen=True)
class Plain:
    """Nothing is remembered, and outputs are called like arguments of C."""

    Sample = Pair

    def init(self):
        return ()

    def step(self, state, sample):
        return state, Two(sample.a + sample.b, sample.a * sample.b)


Wide = NamedTuple("Wide", [(f"input{k}", float) for k in range(33)])


@dataclass(frozen=True)
class Many:
    """More inputs than a mask has bits."""

    Sample = Wide

    def init(self):
        return ()

    def step(self, state, sample):
        return state, Two(sample[0], sample[32])


def test_more_inputs_than_a_mask_has_bits_are_refused(tmp_path):
    subject = subject_of_block("many", Many(), 100.0)
    with pytest.raises(ParameterError, match="takes 33 inputs, and a mask of valid ones has 32 bits"):
        exported(subject, tmp_path, validity=True)


@needs_gcc
@pytest.mark.parametrize("flag", ["-ffast-math", "-ffinite-math-only"])
def test_options_that_break_missing_values_are_refused_by_the_source(tmp_path, flag):
    subject = subject_of_block("plain", Plain(), 100.0)
    face = exported(subject, tmp_path)
    with pytest.raises(AssertionError, match="NaN means that a value is missing"):
        run(face, tmp_path, random_inputs(subject, 10), flags=(flag,))


@needs_gcc
def test_outputs_that_are_called_like_arguments_cause_no_warning(tmp_path):
    assert same_as_scan(Plain(), tmp_path)


@dataclass(frozen=True)
class Copies:
    """Two branches, after each of which a state takes over the same input."""

    Sample = Pair

    class State(NamedTuple):
        first: float
        second: float

    def init(self):
        return self.State(0.0, 0.0)

    def step(self, state, sample):
        sums = []
        for sign, own in ((1.0, state.first), (-1.0, state.second)):
            value = own
            for k in range(branches.FEWEST + 1):
                value = sign * value * value + float(k)
            sums.append(maths.where(sign * sample.a > 0.0, value, sample.b))
        return self.State(sample.b, sample.b), Two(*sums)


@needs_gcc
@pytest.mark.parametrize("longest", [9, 100])
def test_stores_after_branches_that_share_a_function_read_an_input_each(tmp_path, monkeypatch, longest):
    monkeypatch.setattr(c_source, "CutPrinter", functools.partial(CutPrinter, longest=longest))
    assert same_as_scan(Copies(), tmp_path)
