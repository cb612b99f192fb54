"""Dependency graph of a step: stores as operations, and the operations that each one depends on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace

from tierod.core.graph.operations import NEXT_STATE, PUSH, RING, STATE, Operation, Program

STORE, CLOCK = "store", "clock"
"""Operations that store an output: STORE takes its value, CLOCK the conditions on which a clock counts."""

Target = tuple[int, int]
"""(group, position) of an output."""


@dataclass(frozen=True)
class Net:
    """Operations and stores of a step with their dependencies.

    Args:
        program: with its stores as operations
        needed: stores, and the operations on which they depend
        after: store -> operations that read the old value which it overwrites
    """

    program: Program
    needed: frozenset[int]
    after: Mapping[int, Set[int]]

    def is_work(self, index: int) -> bool:
        """Whether an operation is executed in every step."""
        return index in self.needed

    def awaited(self, index: int) -> set[int]:
        """Executed operations that must precede an operation."""
        return {each for each in self.program.operations[index].arguments if each in self.needed} | set(
            self.after.get(index, ())
        )

    def target(self, index: int) -> Target | None:
        """Output that an operation stores; None for any other operation."""
        operation = self.program.operations[index]
        target: Target | None = operation.constant if operation.name in (STORE, CLOCK) else None
        return target


def net_of(program: Program, needs: Mapping[Target, Set[int]], counted: Set[Target]) -> Net:
    """Dependency graph of a step.

    Args:
        program: of the step
        needs: values that the store of each output uses
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
    """Dependency graph of a program that contains its stores already.

    Args:
        program: with its stores as operations
        stores: numbers of these operations
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
