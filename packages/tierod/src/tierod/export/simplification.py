"""Simplification of a step for control units, equal to the last bit, and sums in the order that suits single precision.

Three kinds of operations are removed. The comparison of a value selected from two constants is replaced by the
condition of the selection. The presence test of a value that was replaced by infinity if missing is replaced by the
condition of that replacement. A step counter compared by `time * (count - 0.5) < limit` with a positive time is
compared with a whole number that is computed once. Chains of selections are merged into one operation here too, so
that all printers of the step find the same parameter-dependent values.

The variance of a Kalman filter becomes `(variance - gain) + growth`. In single precision either term may be below half
a unit in the last place of the variance and is then rounded away, always in the same direction. On a drive with rising
friction the error was 0.004 N m; with `variance + (growth - gain)`, rounded once, it is 0.0002 N m."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from tierod.core.graph.operations import (
    LOGICAL,
    NEXT_STATE,
    STATE,
    TUNING,
    Builder,
    Operation,
    Program,
    drop_unused,
    invariant_of,
    is_constant,
    with_picks,
)


def simplified(program: Program, initial: Program, tuning: Sequence[float]) -> Program:
    """An equivalent step with fewer operations; equal to the last bit."""
    simpler = _Simpler(program, counters(program, initial), tuning)
    operations, outputs = drop_unused(simpler.builder.operations, simpler.outputs())
    found = replace(program, operations=tuple(operations), outputs=outputs, invariant=invariant_of(operations))
    return with_picks(found)


def counters(program: Program, initial: Program) -> frozenset[int]:
    """Positions of the states that are whole numbers of steps, or infinity before the first event."""
    first = {k: initial.operations[v] for (group, k), v in initial.outputs.items() if group == NEXT_STATE}
    found = {k for k, each in first.items() if each.name == "constant" and each.constant in (0.0, math.inf)}
    # Counters may copy each other, so all candidates are assumed to count until one is refuted.
    while True:
        kept = {k for k in found if _counts(program, program.outputs[NEXT_STATE, k], found)}
        if kept == found:
            return frozenset(found)
        found = kept


def _counts(program: Program, index: int, states: set[int] | frozenset[int]) -> bool:
    operation = program.operations[index]
    if operation.name == "constant":
        return is_constant(operation, 0.0)
    if operation.name == "input":
        group, position = operation.constant
        return bool(group == STATE) and position in states
    if operation.name in ("select", "if"):
        return all(_counts(program, each, states) for each in operation.arguments[1:])
    return operation.name == "add" and any(
        is_constant(program.operations[one], 1.0) and _counts(program, other, states)
        for one, other in (operation.arguments, operation.arguments[::-1])
    )


class _Simpler:
    def __init__(self, program: Program, counting: frozenset[int], tuning: Sequence[float]):
        self.program, self.counting, self.tuning = program, counting, tuning
        self.builder = Builder()
        self.new: dict[int, int] = {}
        for index, operation in enumerate(program.operations):
            self.new[index] = self._written(index, operation)

    def outputs(self) -> dict[tuple[int, int], int]:
        return {target: self.new[value] for target, value in self.program.outputs.items()}

    def _written(self, index: int, operation: Operation) -> int:
        arguments = tuple(self.new[each] for each in operation.arguments)
        if index in self.program.invariant:
            return self.builder.add(operation.name, arguments, operation.constant)
        if operation.name == "lt":
            counted = self._counted(operation)
            return self._less(*arguments) if counted is None else counted
        if operation.name == "not":
            return self._not(arguments[0])
        if operation.name in ("select", "if"):
            return self._chosen(operation.name, arguments)
        return self.builder.add(operation.name, arguments, operation.constant)

    def _operation(self, index: int) -> Operation:
        return self.builder.operations[index]

    def _constant(self, index: int) -> float | None:
        operation = self._operation(index)
        return float(operation.constant) if operation.name == "constant" else None

    def _is_truth(self, index: int) -> bool:
        return self._operation(index).name in LOGICAL

    def _not(self, index: int) -> int:
        operation = self._operation(index)
        if operation.name == "not" and self._is_truth(operation.arguments[0]):
            return operation.arguments[0]
        return self.builder.add("not", (index,))

    def _chosen(self, name: str, arguments: tuple[int, ...]) -> int:
        """Selection of one of two values; a selection of 1 or 0 is the condition itself."""
        condition, first, *rest = arguments
        inner, other = self._operation(first), self._operation(rest[0]) if rest else Operation("constant", (), 0.0)
        if name == "if" and inner.name == "if" and inner.arguments[0] == condition:
            return first
        if self._is_truth(condition):
            if is_constant(inner, 1.0) and is_constant(other, 0.0):
                return condition
            if is_constant(inner, 0.0) and is_constant(other, 1.0):
                return self._not(condition)
        return self.builder.add(name, arguments)

    def _less(self, first: int, second: int) -> int:
        present = self._present(first) if self._constant(second) == math.inf else None
        if present is not None:
            return present
        for asked, other, is_first in ((first, second, True), (second, first, False)):
            limit, pair = self._constant(other), self._pair(asked)
            if limit is not None and pair is not None:
                condition, values = pair
                answers = tuple(each < limit if is_first else limit < each for each in values)
                if answers == (True, False):
                    return condition
                if answers == (False, True):
                    return self._not(condition)
        return self.builder.add("lt", (first, second))

    def _pair(self, index: int) -> tuple[int, tuple[float, float]] | None:
        """Condition and values of a selection between two constants; None for any other value."""
        operation = self._operation(index)
        if self._is_truth(index):
            return index, (1.0, 0.0)
        if operation.name not in ("select", "if") or not self._is_truth(operation.arguments[0]):
            return None
        values = [self._constant(each) for each in operation.arguments[1:]] + [0.0]
        if values[0] is None or values[1] is None:
            return None
        return operation.arguments[0], (values[0], values[1])

    def _present(self, magnitude: int) -> int | None:
        """Condition equivalent to the finiteness test of a value set to infinity where missing; None if none is."""
        operation = self._operation(magnitude)
        chosen = self._operation(operation.arguments[0]) if operation.name == "fabs" else operation
        if operation.name != "fabs" or chosen.name != "select" or self._constant(chosen.arguments[2]) != math.inf:
            return None
        condition, value, _ = chosen.arguments
        asked = self._operation(condition)
        if asked.name != "lt" or self._operation(asked.arguments[0]) != Operation("fabs", (value,)):
            return None
        limit = self._constant(asked.arguments[1])
        return condition if limit is not None and not math.isnan(limit) else None

    def _counted(self, operation: Operation) -> int | None:
        """`time * (count - 0.5) < limit` as a comparison of the counter with a whole number.

        The smallest count that fails is one of three whole numbers, since rounding moves it by less than one. The time
        must be positive, else the comparison holds for large counts.
        """
        operations, fixed = self.program.operations, self.program.invariant
        first, limit = operation.arguments
        if operations[first].name != "mul" or limit not in fixed:
            return None
        for time, more in (operations[first].arguments, operations[first].arguments[::-1]):
            less = operations[more]
            if (
                self._is_positive(operations[time])
                and less.name == "sub"
                and is_constant(operations[less.arguments[1]], 0.5)
                and _counts(self.program, less.arguments[0], self.counting)
            ):
                least = self._least(self.new[time], self.new[limit], self.new[less.arguments[1]])
                return self.builder.add("lt", (self.new[less.arguments[0]], least))
        return None

    def _is_positive(self, time: Operation) -> bool:
        if time.name == "input":
            group, position = time.constant
            return bool(group == TUNING) and self.tuning[position] > 0.0
        return time.name == "constant" and float(time.constant) > 0.0

    def _least(self, time: int, limit: int, half: int) -> int:
        """Smallest count at which `time * (count - 0.5) < limit` fails."""
        add = self.builder.add
        near = add("floor", (add("add", (add("div", (limit, time)), half)),))
        one = add("constant", (), 1.0)
        next_ = add("add", (near, one))
        holds = [add("lt", (add("mul", (time, add("sub", (each, half)))), limit)) for each in (near, next_)]
        return add("add", (add("add", (near, holds[0])), holds[1]))


# Operations that change a state, and the position of the state among their arguments
_STATE_IN = {"fma": 2, "fnma": 2, "sub": 0}


def growth_first(program: Program) -> Program:
    """Program in which the parameter-dependent growth of a state is added to its change before both reach the state."""
    uses = Counter(argument for each in program.operations for argument in each.arguments)
    uses.update(program.outputs.values())
    operations: list[Operation] = []
    new: dict[int, int] = {}
    for index, each in enumerate(program.operations):
        found = _changed(program, each, uses)
        if found is not None:
            change, growth = found
            given = [new[value] for value in change.arguments]
            state, given[_STATE_IN[change.name]] = given[_STATE_IN[change.name]], new[growth]
            operations.append(Operation(change.name, tuple(given)))
            operations.append(Operation("add", (state, len(operations) - 1)))
        else:
            operations.append(each._replace(arguments=tuple(new[value] for value in each.arguments)))
        new[index] = len(operations) - 1
    kept, outputs = drop_unused(operations, {target: new[value] for target, value in program.outputs.items()})
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=invariant_of(kept))


def _changed(program: Program, each: Operation, uses: Counter[int]) -> tuple[Operation, int] | None:
    """Change of a state that is used only in this sum, and the growth added to it; None for any other operation."""
    for first, growth in (each.arguments, each.arguments[::-1]) if each.name == "add" else ():
        change = program.operations[first]
        if (
            change.name in _STATE_IN
            and uses[first] == 1
            and _is_state(program, change.arguments[_STATE_IN[change.name]])
            and _is_growth(program, growth)
        ):
            return change, growth
    return None


def _is_state(program: Program, index: int) -> bool:
    operation = program.operations[index]
    return operation.name == "input" and operation.constant[0] == STATE


def _is_growth(program: Program, index: int) -> bool:
    """Whether a value depends on parameters only, possibly enabled by a condition."""
    operation = program.operations[index]
    return index in program.invariant or (operation.name == "if" and operation.arguments[1] in program.invariant)
