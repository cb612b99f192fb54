"""Blocks whose C is easily printed wrong give the bits of `scan`: delays, zeros with a sign, counted times, banks."""

import functools
import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bank_of_graph import bank
from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, rounded, run, worst_share
from tierod.core.block import Ring
from tierod.core.errors import ParameterError
from tierod.core.graph import maths
from tierod.core.graph import operations as branches
from tierod.export import c_source
from tierod.export.cut_printer import CutPrinter
from tierod.export.segments import LONGEST
from tierod.export.subject import subject_of, subject_of_block
from tierod.export.vectors import random_inputs

NATIVE = ("-O3", "-march=native", "-ffp-contract=off")


class Two(NamedTuple):
    x: float
    y: float


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


@dataclass(frozen=True)
class Lines:
    """Delay lines that begin with parameters."""

    first: Annotated[float, ""] = 0.3
    slope: Annotated[float, ""] = 2.0
    sizes: tuple[int, int, int] = (3, 1, 5)
    Sample = Pair

    def init(self):
        one, two, three = self.sizes
        return Ring(one, self.first), Ring(two, self.first * self.slope + 1.0), Ring(three, math.nan)

    def step(self, state, sample):
        one, two, three = state
        after = one.push(sample.a), two.push(sample.b), three.push(sample.a)
        return after, Two(one.oldest + two.oldest, three.oldest)


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


@dataclass(frozen=True)
class Counted:
    """A counter that is compared as a time, with any sign."""

    time: Annotated[float, "s"] = 0.01
    longest: Annotated[float, "s"] = 0.25
    Sample = Pair

    def init(self):
        return math.inf

    def step(self, state, sample):
        count = maths.where(maths.absolute(sample.a) < 0.5, 0.0, state + 1.0)
        return count, Two(maths.where((count - 0.5) * self.time < self.longest, sample.b * sample.b, -1.0), count)


@dataclass(frozen=True)
class Copies:
    """Two branches, after each of which a state takes over the same input."""

    Sample = Pair

    def init(self):
        return 0.0, 0.0

    def step(self, state, sample):
        sums = []
        for sign, own in zip((1.0, -1.0), state, strict=True):
            value = own
            for k in range(branches.FEWEST + 1):
                value = sign * value * value + float(k)
            sums.append(maths.where(sign * sample.a > 0.0, value, sample.b))
        return (sample.b, sample.b), Two(*sums)


@dataclass(frozen=True)
class ManyDelays:
    """Several delays of two inputs, and one line whose first numbers are others."""

    gain: Annotated[float, ""] = 2.0
    Sample = Pair

    class State(NamedTuple):
        past: tuple
        own: Ring

    def init(self):
        delays = ((2, 5, 9), (2, 5, 7))
        return self.State(tuple(tuple(Ring(delay, 0.5) for delay in row) for row in delays), Ring(4, -1.0))

    def step(self, state, sample):
        given = (self.gain * sample.a, sample.b)
        past = tuple(tuple(line.push(x) for line in row) for row, x in zip(state.past, given, strict=True))
        values = (*(line.oldest for row in state.past for line in row), state.own.oldest)
        return self.State(past, state.own.push(given[0])), (values,)


@dataclass(frozen=True)
class LateReader:
    """Pushes its input at once, and takes the oldest value after more operations than one function holds."""

    gain: Annotated[float, ""] = 0.99
    Sample = Pair

    def init(self):
        return Ring(3, 0.25)

    def step(self, state, sample):
        value = sample.a
        for k in range(3 * LONGEST):
            value = self.gain * value + float(k)
        return state.push(sample.b), Two(value + state.oldest, value)


BLOCKS = [
    *(TunedChoice(number) for number in (9.0, 10.0, 2.5)),
    *(Lines(sizes=sizes) for sizes in ((3, 1, 5), (2, 70_000, 65_535))),
    NegativeZero(),
    *(Counted(time, longest) for time, longest in ((-0.5, 0.25), (0.01, -0.004), (0.0, 0.25), (0.01, 0.095))),
    Copies(),
    LateReader(),
]


@needs_gcc
@pytest.mark.parametrize("block", BLOCKS, ids=str)
def test_the_c_of_a_block_gives_the_bits_of_scan(block, tmp_path):
    subject = subject_of_block("block", block, 100.0)
    inputs = rounded(random_inputs(subject, 400))
    face = exported(subject, tmp_path, inputs, precision="double")
    found, wanted = run(face, tmp_path, inputs), reference(subject, inputs)
    assert np.array_equal(np.signbit(found), np.signbit(wanted))
    assert np.array_equal(found, wanted, equal_nan=True)


@needs_gcc
def test_stores_after_branches_that_share_a_function_read_an_input_each(tmp_path, monkeypatch):
    monkeypatch.setattr(c_source, "CutPrinter", functools.partial(CutPrinter, longest=9))
    test_the_c_of_a_block_gives_the_bits_of_scan(Copies(), tmp_path)


@needs_gcc
def test_delays_of_one_signal_share_a_line_and_equal_scan_to_the_last_bit(tmp_path):
    subject = subject_of_block("late", ManyDelays(), 100.0, "Many delays")
    inputs = random_inputs(subject, 60)
    face = exported(subject, tmp_path, inputs=inputs, precision="double")
    assert np.array_equal(run(face, tmp_path, inputs), reference(subject, inputs), equal_nan=True)
    header = (tmp_path / "tierod_late.h").read_text()
    assert "tierod_late_real_t past[2][9];" in header
    assert header.count("_head;") == 2


@needs_gcc
@pytest.mark.parametrize(("precision", "validity", "share"), [("double", False, 0.0), ("single", True, 1e-4)])
def test_a_bank_with_feedback_delay_lines_and_exchanged_lanes_states_what_scan_states(
    tmp_path, precision, validity, share
):
    small = subject_of_block("small", bank(), 100.0, "A bank")
    inputs = random_inputs(small, 400)
    face = exported(small, tmp_path, inputs=inputs, precision=precision, validity=validity, libm=False)
    wanted = reference(small, inputs)
    assert np.ptp(wanted[:, 1]) > 0.0  # lanes are taken over, now these, now those
    assert worst_share(run(face, tmp_path, inputs, flags=NATIVE), wanted).max() <= share


@needs_gcc
@pytest.mark.parametrize(
    ("monitor", "vehicle"), [("sideslip", "midsize-eps"), pytest.param("condition", "rav4", marks=pytest.mark.slow)]
)
def test_with_the_kernels_own_functions_the_export_is_the_kernel_to_the_last_bit(tmp_path, monitor, vehicle):
    subject = subject_of(monitor, vehicle)
    inputs = rounded(random_inputs(subject, 1500, seed=3))
    face = exported(subject, tmp_path, inputs[:50], precision="double", libm=False)
    found = run(face, tmp_path, inputs, flags=("-O1", *NATIVE[1:]))
    assert np.array_equal(found, reference(subject, inputs), equal_nan=True)


class Level(NamedTuple):
    level: float


@dataclass(frozen=True)
class Variance:
    """Variance of a number that is measured again and again, and wanders."""

    growth: Annotated[float, ""] = 2.9e-8
    noise: Annotated[float, ""] = 1e7
    Sample = Pair

    def init(self):
        return Level(1.0)

    def step(self, state, sample):
        gain = state.level / (state.level + self.noise)
        level = state.level - gain * state.level
        level = level + maths.where(sample.a > 0.0, self.growth, 0.0)
        return Level(level), Level(level)


@needs_gcc
def test_growth_that_is_less_than_the_last_bit_of_a_variance_is_not_rounded_away(tmp_path):
    subject = subject_of_block("variance", Variance(), 100.0, "A variance")
    inputs = np.ones((200_000, 2))
    face = exported(subject, tmp_path, inputs=inputs[:100], precision="single")
    assert abs(run(face, tmp_path, inputs)[-1, 0] - reference(subject, inputs)[-1, 0]) < 5e-3


Wide = NamedTuple("Wide", [(f"input{k}", float) for k in range(33)])


@dataclass(frozen=True)
class Many:
    """More inputs than a mask has bits, outputs called like arguments of C."""

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
def test_options_that_break_missing_values_are_refused_by_the_source(tmp_path):
    subject = subject_of_block("plain", Many(), 100.0)
    face = exported(subject, tmp_path)
    with pytest.raises(AssertionError, match="NaN means that a value is missing"):
        run(face, tmp_path, random_inputs(subject, 10), flags=("-ffast-math",))
