"""What is printed with tables, branches and whole numbers is what the block says, to the last bit."""

from dataclasses import dataclass

import numpy as np

from bank_of_graph import Pair
from tierod.core.graph import KEEP, Bank, Verdict, maths, scan

LANES = 12


def by_number(values, number):
    result = values[0]
    for place, value in enumerate(values[1:], 1):
        result = maths.where(number == place, value, result)
    return result


def costly(x):
    for k in range(1, 20):
        x = maths.sin(x) + k * x
    return x


@dataclass(frozen=True)
class Level:
    """A smoothed signal."""

    share: float
    Sample = Pair

    def init(self):
        return 0.0

    def step(self, state, sample):
        level = state + self.share * (maths.where(maths.present(sample.a), sample.b, 0.5) - 0.4 - state)
        return level, (level, self.share)


@dataclass(frozen=True)
class ChoosingJudge:
    """Picks by a number, and works out what is seldom needed."""

    count: int = LANES

    def feedback(self):
        return ()

    def init(self):
        return 0.0

    def step(self, state, sample):
        number, rarely = sample.sample.a, sample.sample.b > 0.5
        levels = [lane[0] for lane in sample.lanes]
        picked, doubled = by_number(levels, number), by_number([2.0 * level for level in levels], number)
        inner = maths.where(picked > 0.0, costly(picked), -1.0)
        seldom = maths.where(rarely, costly(doubled) + inner, 0.0)
        never_alone = costly(picked + 1.0)
        flags = (picked > 0.0) + (doubled > 0.0) + maths.negated(rarely)
        chosen = maths.where(maths.negated(rarely), never_alone, seldom)
        again = maths.where(chosen > 3.0, costly(chosen), maths.where(rarely, costly(chosen + 1.0), chosen))
        count = state + maths.where(maths.either(rarely, chosen > 0.0), 1.0, 0.0)
        return count, Verdict((picked, doubled, seldom, chosen, again, flags, count), (KEEP,) * self.count)


def bank():
    return Bank(tuple(Level(0.1 + 0.05 * k) for k in range(LANES)), ChoosingJudge())


def samples():
    numbers = np.tile([0.0, 1.0, 5.0, 11.0, 12.0, -1.0, 2.5, np.nan, np.inf, -np.inf, 1e300], 20)
    return np.column_stack([numbers, np.random.default_rng(3).uniform(0.0, 1.0, len(numbers))])


def test_it_is_what_plain_numbers_and_the_virtual_machine_give():
    block, given = bank(), samples()
    compiled = scan(block, given).values
    state, rows = block.init(), []
    for row in given:
        state, output = block.step(state, Pair(*row.tolist()))
        rows.append(output)
    np.testing.assert_allclose(compiled, np.array(rows), rtol=1e-11)
    np.testing.assert_allclose(scan(block, given, engine="virtual machine").values, compiled, rtol=1e-11)
