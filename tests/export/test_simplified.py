import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, rounded, run
from tierod.core.graph import maths
from tierod.core.graph.operations import NEXT_STATE, SAMPLE, Builder, Program
from tierod.export.nested import Nested, nested
from tierod.export.subject import subject_of_block
from tierod.export.vectors import random_inputs


class Held(NamedTuple):
    """What was held, and for how long."""

    value: float
    recent: float


@dataclass(frozen=True)
class Hold:
    """A value that is held for a time, and one that is worked out in one case alone."""

    time: Annotated[float, "s"] = 0.01
    longest: Annotated[float, "s"] = 0.25
    Sample = Pair

    class State(NamedTuple):
        value: float
        age: float

    def init(self):
        return self.State(0.0, math.inf)

    def step(self, state, sample):
        given = maths.where(maths.absolute(sample.a) < 2.0, sample.a, math.inf)
        there = maths.present(given)
        age = maths.where(there, 0.0, state.age + 1.0)
        recent = self.time * (age - 0.5) < self.longest
        value = maths.where(there, given, state.value)
        shown = maths.where(recent, value + sample.b * sample.b, 0.0)
        return self.State(value, age), Held(shown, maths.where(recent, 1.0, 0.0))


@needs_gcc
@pytest.mark.parametrize(("time", "longest"), [(0.01, 0.25), (0.01, 0.095), (0.02, 0.07), (0.1, 0.05), (0.003, 0.0)])
def test_the_simplified_step_equals_scan_to_the_last_bit(tmp_path, time, longest):
    subject = subject_of_block("hold", Hold(time, longest), 1.0 / time, "A hold")
    inputs = rounded(random_inputs(subject, 4000))
    face = exported(subject, tmp_path, precision="double")
    assert np.array_equal(run(face, tmp_path, inputs), reference(subject, inputs), equal_nan=True)


def test_a_negation_that_selections_take_as_a_value_is_worked_out():
    made = Builder()
    one, two = (made.add("input", constant=(SAMPLE, place)) for place in (0, 1))
    condition, other = (made.add("lt", pair) for pair in ((one, two), (two, one)))
    negated, square = made.add("not", (other,)), made.add("mul", (two, two))
    shown = made.add("add", (square, one))
    first, second = made.add("select", (condition, negated, shown)), made.add("select", (condition, two, negated))
    step = Program(tuple(made.operations), {(NEXT_STATE, 0): first, (NEXT_STATE, 1): second}, frozenset())
    own = (condition, other, negated, square, shown, first, second)
    uses = {index: {user for user in own if index in step.operations[user].arguments} for index in (one, two, *own)}
    found = list(nested(step, own, uses | {first: {-1}, second: {-1}}))
    assert any(isinstance(each, Nested) and set(each.chosen) == {first, second} for each in found)
    assert negated in found
