"""Random steps as programs of operations, with inputs that are seldom met."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

import numpy as np

from tierod.core.graph.operations import (
    NEXT_STATE,
    OUTPUT,
    PUSH,
    SAMPLE,
    STATE,
    TUNING,
    Builder,
    Operation,
    Program,
    drop_unused,
    invariant_of,
    is_constant,
)
from tierod.export.vectors import rounded

SPECIAL = (0.0, -0.0, 1.0, -1.0, 0.5, 2.0, math.inf, -math.inf, math.nan, 5e-324, -1e-310, 1e300, -3.0, 7.0)
CONSTANTS = (0.0, 1.0, -1.0, 0.5, 2.0, 3.0, math.inf, -math.inf, 0.1, -0.0, 1e-40, 1e300)

OF_ONE = ("neg", "inverse", "fabs", "sign", "floor", "ceil", "sqrt", "assign")
OF_LIBRARY = ("sin", "exp", "log", "atan", "tanh")
OF_TWO = ("add", "sub", "mul", "div", "add", "sub", "mul")
OF_THREE = ("fma", "fms", "fnma")
COMPARISONS = ("lt", "le", "eq", "ne")


@dataclass(frozen=True)
class Made:
    """A random step with all that its export needs."""

    step: Program
    initial: Program
    tuning: tuple[float, ...]
    rings: tuple[int, ...]
    inputs: int

    @property
    def states(self) -> int:
        return sum(group == NEXT_STATE for group, _ in self.step.outputs)

    @property
    def outputs(self) -> int:
        return sum(group == OUTPUT for group, _ in self.step.outputs)


class _Maker:
    """Builds one random step; patterns that the printer treats in a way of their own occur often."""

    def __init__(self, seed: int):
        self.chance = random.Random(seed)
        self.builder = Builder()
        take = self.chance.randint
        self.sizes = (take(0, 4), take(1, 6), take(0, 2), take(1, 5))
        self.numbers = [self._input(group, k) for group, size in enumerate(self.sizes) for k in range(size)]
        self.truths: list[int] = []
        self.first = [self.chance.choice((0.0, 0.0, 1.0, math.inf, math.nan, -0.0, -2.5)) for _ in range(self.sizes[1])]

    def _input(self, group: int, place: int) -> int:
        return self.builder.add("input", constant=(group, place))

    def constant(self, value: float | None = None) -> int:
        return self.builder.add("constant", (), self.chance.choice(CONSTANTS) if value is None else value)

    def number(self) -> int:
        """A value that is there already; most often a late one."""
        if self.chance.random() < 0.12:
            return self.constant()
        if self.truths and self.chance.random() < 0.06:
            return self.chance.choice(self.truths)
        recent = self.numbers[-12:] if self.chance.random() < 0.6 else self.numbers
        return self.chance.choice(recent)

    def truth(self) -> int:
        """A condition, old or new; now and then a number that is no truth."""
        draw = self.chance.random()
        if draw < 0.03:
            return self.number()
        if self.truths and draw < 0.5:
            return self.chance.choice(self.truths[-6:] if draw < 0.25 else self.truths)
        return self.new_truth()

    def new_truth(self) -> int:
        draw, add = self.chance.random(), self.builder.add
        if draw < 0.15:
            made = add("lt", (add("fabs", (self.number(),)), self.constant(math.inf)))
        elif draw < 0.6 or not self.truths:
            made = add(self.chance.choice(COMPARISONS), (self.number(), self.number()))
        elif draw < 0.8:
            made = add("not", (self.truth_or_number(),))
        else:
            made = add(self.chance.choice(("and", "or")), (self.truth_or_number(), self.truth_or_number()))
        self.truths.append(made)
        return made

    def truth_or_number(self) -> int:
        return self.number() if self.chance.random() < 0.1 else self.chance.choice(self.truths)

    def more(self, count: int) -> int:
        """So many new operations, each with late values; the last of them."""
        made = self.number()
        for _ in range(count):
            made = self._one()
            self.numbers.append(made)
        return made

    def _one(self) -> int:
        draw, add, choice = self.chance.random(), self.builder.add, self.chance.choice
        if draw < 0.65:
            arity, names = (2, OF_TWO) if draw < 0.4 else (3, OF_THREE) if draw < 0.5 else (1, OF_ONE)
            name, arguments = choice(names), tuple(self.number() for _ in range(arity))
            return arguments[0] if self._is_mistaken(name, arguments) else add(name, arguments)
        if draw < 0.68:
            return add(choice(OF_LIBRARY), (self._input(SAMPLE, 0),))
        if draw < 0.74:
            return self._presence()
        if draw < 0.78:
            return add("if", (self.truth(), self.number()))
        if draw < 0.82:
            self.truths.append(add("select", (self.truth(), self.truth(), self.truth())))
            return self.truths[-1]
        if draw < 0.84:
            self.truths.append(self._compared_choice())
            return self.truths[-1]
        return add("select", (self.truth(), self.number(), self.number()))

    def _is_mistaken(self, name: str, arguments: tuple[int, ...]) -> bool:
        """Whether GCC 12 gives a zero of the wrong sign: for 0.0 less a truth, which CasADi writes as a negation."""
        return name == "sub" and is_constant(self.builder.operations[arguments[0]], 0.0)

    def _presence(self) -> int:
        """A value that is infinite unless it is small; whether it is there is asked next."""
        add, value = self.builder.add, self.number()
        asked = add("lt", (add("fabs", (value,)), self.constant()))
        given = add("select", (asked, value, self.constant(math.inf)))
        self.truths += [asked, add("lt", (add("fabs", (given,)), self.constant(math.inf)))]
        return given

    def _compared_choice(self) -> int:
        add = self.builder.add
        pair = (self.constant(), self.constant())
        chosen = add("select", (self.truth(), *pair)) if self.chance.random() < 0.7 else self.truth()
        limit = self.constant()
        return add("lt", (chosen, limit) if self.chance.random() < 0.5 else (limit, chosen))

    def chain(self) -> int:
        """A value by its number."""
        add, length = self.builder.add, self.chance.randint(7, 11)
        number, made = self.number(), self.number()
        for k in range(1, length + 1):
            made = add("select", (add("eq", (number, self.constant(float(k)))), self.number(), made))
        return made

    def branch(self, depth: int) -> int:
        """A selection whose sides are worked out for it alone, with selections within."""
        before = list(self.numbers)
        condition = self.truth()
        sides = []
        for _ in range(2):
            self.numbers = list(before)
            last = self.more(self.chance.choice((0, 1, 3, 20, 40)))
            if depth and self.chance.random() < 0.6:
                last = self.builder.add("add", (last, self.branch(depth - 1)))
            sides.append(last)
        self.numbers = before
        if self.chance.random() < 0.3:
            condition = self.builder.add("not", (condition,))
        name = "if" if self.chance.random() < 0.25 else "select"
        made = self.builder.add(name, (condition, *sides[: 1 if name == "if" else 2]))
        for _ in range(self.chance.randint(0, 2)):
            others = (self.chance.choice((sides[0], self.number())), self.chance.choice((sides[1], self.number())))
            self.numbers.append(self.builder.add("select", (condition, *others)))
        self.numbers.append(made)
        return made

    def counter(self, position: int) -> int:
        """The next value of a state that counts; it is compared as a time."""
        add, own = self.builder.add, self._input(STATE, position)
        self.first[position] = self.chance.choice((0.0, math.inf))
        more = add("add", (own, self.constant(1.0)))
        following = add("select", (self.truth(), self.constant(0.0), more))
        fixed = [self._input(TUNING, k) for k in range(self.sizes[0])] + [self.constant(0.25), self.constant(0.01)]
        time, limit = self.chance.choice(fixed), self.chance.choice(fixed)
        since = add("mul", (time, add("sub", (self.chance.choice((own, following)), self.constant(0.5)))))
        self.truths.append(add("lt", (since, limit)))
        return following

    def clock(self, position: int) -> int:
        """The next value of a state that sums one step."""
        add, own = self.builder.add, self._input(STATE, position)
        self.first[position] = 0.0
        step = self._input(TUNING, 0) if self.sizes[0] else self.constant(0.01)
        if self.chance.random() < 0.5:
            step = add("if", (self.truth(), step))
        return add("select", (self.truth(), add("add", (own, step)), self.chance.choice((own, self.constant(0.0)))))

    def made(self) -> Made:
        chance = self.chance
        following: dict[int, int] = {}
        for position in range(self.sizes[1]):
            kind = chance.random()
            if kind < 0.35:
                following[position] = (self.counter if kind < 0.2 else self.clock)(position)
        for _ in range(chance.randint(1, 5)):
            draw = chance.random()
            if draw < 0.1:
                self.numbers.append(self.chain())
            elif draw < 0.7:
                self.branch(chance.randint(0, 2))
            else:
                self.more(chance.randint(1, 60))
        for position in range(self.sizes[1]):
            other = self._input(STATE, chance.randrange(self.sizes[1]))
            following.setdefault(position, other if chance.random() < 0.3 else self.number())
        outputs = {(NEXT_STATE, k): value for k, value in following.items()}
        outputs |= {(PUSH, k): self.number() for k in range(self.sizes[2])}
        outputs |= {(OUTPUT, k): self.number() for k in range(chance.randint(1, 8))}
        operations, kept = drop_unused(self.builder.operations, outputs)
        step = Program(tuple(operations), dict(sorted(kept.items())), invariant_of(operations))
        values = tuple(chance.choice((0.01, 0.25, 1.5, -0.7, 3.0, 0.0, 1e-3)) for _ in range(self.sizes[0]))
        rings = tuple(chance.randint(1, 4) for _ in range(self.sizes[2]))
        return Made(step, self._initial(), values, rings, self.sizes[3])

    def _initial(self) -> Program:
        first = [*self.first, *([0.25] * self.sizes[2])]
        operations = tuple(Operation("constant", (), value) for value in first)
        count = len(self.first)
        outputs = {(NEXT_STATE, k): k for k in range(count)}
        outputs |= {(PUSH, k): count + k for k in range(self.sizes[2])}
        return Program(operations, outputs, frozenset(range(len(operations))))


def random_step(seed: int) -> Made:
    """A random step; the same for the same seed."""
    return _Maker(seed).made()


def random_samples(made: Made, steps: int, seed: int) -> np.ndarray:
    """Inputs (steps, inputs): missing, infinite, subnormal and signed zero among ordinary numbers."""
    chance = random.Random(seed)
    rows = [
        [chance.choice(SPECIAL) if chance.random() < 0.5 else chance.gauss(0.0, 3.0) for _ in range(made.inputs)]
        for _ in range(steps)
    ]
    return rounded(np.array(rows)) if chance.random() < 0.5 else np.array(rows)
