from dataclasses import dataclass
from typing import Annotated, NamedTuple

import pytest

from tierod.core.graph.operations import NEXT_STATE, PUSH
from tierod.core.graph.state import initial_program
from watched_torque import Watch


def test_the_first_state_follows_the_tuning():
    found = initial_program(Watch())
    smooth = found.operations[found.outputs[NEXT_STATE, 2]]
    assert smooth.name == "mul"
    filled = found.operations[found.outputs[PUSH, 0]]
    assert (filled.name, filled.constant) == ("constant", 0.5)


@dataclass(frozen=True)
class Rooted:
    """Begins with what no symbol can follow."""

    size: Annotated[float, ""] = 4.0

    class Sample(NamedTuple):
        """One number."""

        value: float

    def init(self):
        return float(self.size) ** 0.5

    def step(self, state, sample):
        return state + sample.value, state


def test_what_no_symbol_can_follow_begins_with_its_numbers():
    found = initial_program(Rooted())
    first = found.operations[found.outputs[NEXT_STATE, 0]]
    assert (first.name, first.constant) == ("constant", pytest.approx(2.0))
