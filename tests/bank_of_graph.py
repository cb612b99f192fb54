"""A small bank that uses all that a bank can do."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from blocks_of_graph import Everything, Pair
from tierod.core.block import Ring
from tierod.core.graph import KEEP, Bank, Verdict, maths


class Said(NamedTuple):
    level: float


class Marked(NamedTuple):
    result: float
    level: float


@dataclass(frozen=True)
class Lane:
    """Swaps two of its states and calls the C library, now on what it remembers, now on what it has just worked out."""

    gain: Annotated[float, "1/m"] = 0.3
    offset: Annotated[float, ""] = 0.5
    Sample = Pair

    class State(NamedTuple):
        level: float
        first: float
        second: float

    def init(self):
        return self.State(self.offset, self.gain, 0.0)

    def step(self, state, sample, said):
        m = maths
        a = m.where(m.present(sample.a), sample.a, state.level)
        b = m.where(m.present(sample.b), sample.b, 0.5)
        bent = m.tanh(state.level) + m.exp(-self.offset) * m.sin(self.gain * a)
        level = 0.9 * state.level + 0.1 * m.arctan(bent * bent + m.log(1.0 + b * b)) + 0.01 * said.level
        return self.State(level, state.second, state.first), Marked(m.cos(level) + state.first, level)


@dataclass(frozen=True)
class HighestJudge:
    """Every lane that falls too far below the highest takes over its state; the lowest two levels trade places."""

    count: int
    behind: Annotated[float, ""] = 0.05

    def feedback(self):
        return Said(0.25)

    def init(self):
        return 0.0, Ring(5, 0.1)

    def step(self, state, sample):
        changes, line = state
        highest, which = sample.lanes[0].level, 0.0
        for number, lane in enumerate(sample.lanes):
            which = maths.where(lane.level > highest, float(number), which)
            highest = maths.maximum(highest, lane.level)
        adopt = [maths.where(lane.level < highest - self.behind, which, KEEP) for lane in sample.lanes]
        odd = changes - 2.0 * maths.floor(0.5 * changes)
        adopt[0], adopt[1] = (maths.where(odd > 0.0, other, own) for own, other in zip(adopt, (1.0, 0.0), strict=False))
        result = sum(lane.result for lane in sample.lanes)
        total = sum(maths.where(source >= 0.0, 1.0, 0.0) for source in adopt)
        output = Marked(result + line.oldest, total)
        return (changes + 1.0, line.push(highest)), Verdict(output, tuple(adopt), Said(0.1 * highest))


def bank(count=11, kind=Lane):
    return Bank(tuple(kind(0.1 + 0.03 * k, 0.5 - 0.04 * k) for k in range(count)), HighestJudge(count))


def ringed():
    return Bank((Everything(), Everything()), HighestJudge(2))
