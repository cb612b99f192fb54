"""Small blocks that together use every operation that the printer knows."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring
from tierod.core.graph import maths


class Pair(NamedTuple):
    a: Annotated[float, "m"]
    b: Annotated[float, "s"]


class Outcome(NamedTuple):
    result: float
    nested: Pair


@dataclass(frozen=True)
class Everything:
    """Uses each function of maths once."""

    gain: Annotated[float, "1/m"] = 0.3
    offset: Annotated[float, ""] = 0.5
    Sample = Pair

    class State(NamedTuple):
        level: float
        line: Ring
        count: float

    def init(self):
        return self.State(self.offset, Ring(7, 0.25), 0.0)

    def step(self, state, sample):
        m = maths
        a = m.where(m.present(sample.a), sample.a, state.level)
        b = m.where(m.present(sample.b), sample.b, 0.5)
        x = m.limit(a, -3.0, 3.0)
        smooth = m.sin(x) + m.cos(b) + m.tan(0.1 * x) + m.arctan(x) + m.arcsin(0.2 * x) + m.arctan2(x, b)
        grown = m.exp(0.1 * x) + m.expm1(0.1 * b) + m.log(1.0 + x * x) + m.sqrt(m.absolute(b)) + m.hypot(x, b)
        shared = x / (1.0 + b * b) + m.tanh(b) / (1.0 + b * b) + m.sign(x) * m.floor(3.0 * b)
        logic = (
            m.both(x > 0.0, m.either(b < 0.0, m.negated(x == b)))
            + m.all_of(x <= 1.0, b != 0.0)
            + m.any_of(x >= 2.0, b > 1.0)
        )
        level = 0.9 * state.level + self.gain * (m.minimum(smooth, grown) + m.maximum(shared, logic)) * m.exp(
            -self.offset
        )
        count = state.count + m.where(level > state.line.oldest, 1.0, 0.0)
        following = self.State(level, state.line.push(0.5 * level), count)
        return following, Outcome(level - state.line.oldest + m.power(1.5, b), Pair(count, x**3))
