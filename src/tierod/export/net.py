"""A step with what it puts away as operations, and what each of them waits for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace

from tierod.core.graph.operations import NEXT_STATE, PUSH, RING, STATE, Operation, Program

STORE, CLOCK = "store", "clock"
"""An output that is put away, as an operation on its value, or on the conditions on which a clock counts."""

Target = tuple[int, int]
"""(group, position) of an output."""


@dataclass(frozen=True)
class Net:
    """Operations and stores of a step.

    Args:
        program: with its stores as operations
        needed: operations that stores rest on, stores among them
        after: store -> operations that read what it overwrites
    """

    program: Program
    needed: frozenset[int]
    after: Mapping[int, Set[int]]

    def is_work(self, index: int) -> bool:
        """Whether something is worked out or put away in every step."""
        return index in self.needed

    def awaited(self, index: int) -> set[int]:
        """Work that comes before an operation."""
        return {each for each in self.program.operations[index].arguments if each in self.needed} | set(
            self.after.get(index, ())
        )

    def target(self, index: int) -> Target | None:
        """The output that an operation puts away; None for one that does not."""
        operation = self.program.operations[index]
        target: Target | None = operation.constant if operation.name in (STORE, CLOCK) else None
        return target


def net_of(program: Program, needs: Mapping[Target, Set[int]], counted: Set[Target]) -> Net:
    """A step with its stores.

    Args:
        program: of the step
        needs: values that the storing of every output takes
        counted: outputs that are clocks
    """
    operations = list(program.operations)
    stores: dict[Target, int] = {}
    for target in sorted(needs):
        stores[target] = len(operations)
        taken = tuple(sorted(needs[target])) if target in counted else (program.outputs[target],)
        operations.append(Operation(CLOCK if target in counted else STORE, taken, target))
    whole = replace(program, operations=tuple(operations))
    return linked(whole, stores.values())


def linked(program: Program, stores: Iterable[int]) -> Net:
    """A net of operations among which stores are already.

    Args:
        program: with its stores
        stores: their numbers
    """
    operations = program.operations
    work: set[int] = set()
    waiting = list(stores)
    while waiting:
        index = waiting.pop()
        if index not in work and index not in program.invariant and operations[index].name not in ("input", "constant"):
            work.add(index)
            waiting += operations[index].arguments
    readers: dict[Target, set[int]] = {}
    for index in work:
        for each in operations[index].arguments:
            if operations[each].name == "input":
                readers.setdefault(operations[each].constant, set()).add(index)
    source = {NEXT_STATE: STATE, PUSH: RING}
    after = {
        index: readers.get((source[group], position), set()) - {index}
        for index in stores
        for group, position in [operations[index].constant]
        if group in source
    }
    return Net(program, frozenset(work), after)
