"""Values picked by a number that is known at run time only: chains of selections as one operation."""

from __future__ import annotations

from dataclasses import replace

from tierod.core.graph.operations import Operation, Program, drop_unused, invariant_of

FEWEST = 8
"""Values from which a table pays beside selections."""


def with_picks(program: Program) -> Program:
    """The same program with every chain "v1 if n == 1, v2 if n == 2, ... else v0" as one operation, "pick".

    Its arguments are n, v0, v1, ...; a number that is none of 1, 2, ... picks v0, as the chain does.
    """
    operations = list(program.operations)
    for index in range(len(operations)):
        picked = _pick(program.operations, index)
        if picked is not None and index not in program.invariant:
            operations[index] = picked
    kept, outputs = drop_unused(operations, program.outputs)
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=invariant_of(kept))


def _pick(operations: tuple[Operation, ...], index: int) -> Operation | None:
    """The whole chain that ends at an operation, the last value first."""
    values: list[int] = []
    number, wanted = -1, 0.0
    while wanted != 1.0 and operations[index].name == "select":
        condition, value, rest = operations[index].arguments
        compared = _compared(operations, condition)
        if compared is None or (values and compared != (number, wanted - 1.0)):
            break
        number, wanted = compared
        values.append(value)
        index = rest
    if wanted != 1.0 or len(values) < FEWEST:
        return None
    return Operation("pick", (number, index, *reversed(values)))


def _compared(operations: tuple[Operation, ...], condition: int) -> tuple[int, float] | None:
    """The value that is asked whether it equals a constant, and the constant."""
    asked = operations[condition]
    if asked.name != "eq":
        return None
    first, second = asked.arguments
    if operations[first].name == "constant":
        first, second = second, first
    return (first, float(operations[second].constant)) if operations[second].name == "constant" else None
