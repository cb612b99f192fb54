from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring
from tierod.core.graph.analysis import OperationCount, operation_count
from tierod.core.graph.maths import arctan2, cos, sin, sqrt, where


class Pair(NamedTuple):
    a: Annotated[float, ""]
    b: Annotated[float, ""]


class Remembered(NamedTuple):
    sum: float
    line: Ring


@dataclass(frozen=True)
class Counted:
    gain: float = 2.0

    Sample = Pair

    def init(self):
        return Remembered(0.0, Ring(3))

    def step(self, state, sample):
        product = self.gain * self.gain * sample.a  # the square of the tuning is worked out once: one multiplication
        turned = sin(product) + cos(product)  # two trigonometric functions, one addition
        same = sin(self.gain * self.gain * sample.a)  # nothing new
        larger = where(sample.a > sample.b, turned, same)  # a comparison and a selection
        total = state.sum + larger * sample.b  # multiplication and addition, fused
        quotient = sqrt(total) / (sample.b - 1.0)  # a root, a division, a subtraction
        return Remembered(total, state.line.push(quotient)), Pair(arctan2(total, sample.a), state.line.oldest)


def test_every_operation_of_a_step_is_counted_once():
    assert operation_count(Counted()) == OperationCount(
        multiplications=2, additions=3, divisions=1, trigonometric=3, functions=1, decisions=2, states=4
    )
