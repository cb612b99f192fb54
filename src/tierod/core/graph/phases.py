"""Cut a straight line at the functions of the C library, so that all between them vectorises."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.core.graph.operations import NEXT_STATE, STATE, Program

LIBRARY = frozenset(
    ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "expm1", "log", "log1p", "pow")
) | {"hypot"}
"""Operations that are calls of the C library: one of them keeps a compiler from vectorising the loop that holds it."""


@dataclass(frozen=True)
class Phase:
    """What is worked out together.

    Args:
        values: numbers of operations, in order, free of calls
        calls: numbers of operations that follow, calls of the library with arguments from here or earlier
        stores: (group, position) of the outputs that are put away at the end
    """

    values: tuple[int, ...]
    calls: tuple[int, ...]
    stores: tuple[tuple[int, int], ...]


def phases(program: Program) -> list[Phase]:
    """The phases of a program: calls as early as they can, all else as late as its first use lets it.

    A state is not overwritten before the last phase that reads it.
    """
    early = _earliest(program)
    phase = _latest(program, early)
    count = 1 + max((_available(program, index, phase) for index in phase), default=0)
    values: list[list[int]] = [[] for _ in range(count)]
    calls: list[list[int]] = [[] for _ in range(count)]
    for index in sorted(phase):
        operation = program.operations[index]
        if operation.name != "input":
            (calls if operation.name in LIBRARY else values)[phase[index]].append(index)
    stores: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    hold = _free_from(program, phase, count - 1)
    for (group, position), value in sorted(program.outputs.items()):
        copied = program.operations[value].name == "input"
        ready = count - 1 if copied else _available(program, value, phase)
        stores[max(ready, hold.get(position, 0) if group == NEXT_STATE else 0)].append((group, position))
    return [Phase(tuple(v), tuple(c), tuple(s)) for v, c, s in zip(values, calls, stores, strict=True)]


def _is_free(program: Program, index: int) -> bool:
    """Whether a value is at hand in every phase: an input, a constant, or carried."""
    return index in program.invariant or program.operations[index].name in ("input", "constant")


def _available(program: Program, index: int, phase: dict[int, int]) -> int:
    """The first phase that can use a value."""
    if _is_free(program, index):
        return 0
    return phase[index] + (program.operations[index].name in LIBRARY)


def _earliest(program: Program) -> dict[int, int]:
    early: dict[int, int] = {}
    for index, operation in enumerate(program.operations):
        if not _is_free(program, index):
            early[index] = max((_available(program, a, early) for a in operation.arguments), default=0)
    return early


def _latest(program: Program, early: dict[int, int]) -> dict[int, int]:
    last = 1 + max((_available(program, index, early) for index in early), default=0)
    wanted = dict.fromkeys(early, last)
    for value in program.outputs.values():
        if value in early:
            wanted[value] = early[value]
    phase: dict[int, int] = {}
    for index in sorted(early, reverse=True):
        operation = program.operations[index]
        phase[index] = early[index] if operation.name in LIBRARY else wanted[index]
        for argument in operation.arguments:
            if argument in early:
                wanted[argument] = min(wanted[argument], phase[index])
    return phase


def _free_from(program: Program, phase: dict[int, int], last: int) -> dict[int, int]:
    """State -> the first phase at whose end it may be overwritten; one that is put out as it is, is read in the last.

    Calls come after what their phase puts away: a state that one of them takes is still needed then.
    """
    uses = [
        (argument, own + (program.operations[index].name in LIBRARY))
        for index, own in phase.items()
        for argument in program.operations[index].arguments
    ]
    uses += [(value, last) for value in program.outputs.values()]
    read: dict[int, int] = {}
    for index, own in uses:
        operation = program.operations[index]
        if operation.name == "input" and operation.constant[0] == STATE:
            read[operation.constant[1]] = max(read.get(operation.constant[1], 0), own)
    return read
