"""Printing of stores: numbers, codes, and clocks, which count steps."""

from __future__ import annotations

from collections.abc import Mapping

from tierod.core.graph.operations import NEXT_STATE, OUTPUT
from tierod.export.clocks import Clock, added, is_own
from tierod.export.statements import Body, Group, StatementPrinter


class OutputPrinter(StatementPrinter):
    """Printer of the statements and stores of one program.

    Args:
        clocks: states stored as whole numbers of steps
    """

    def __init__(self, body: Body, clocks: Mapping[int, Clock]):
        super().__init__(body)
        self.clocks = clocks

    def _stored(self, target: Group, named: dict[int, str], indent: str) -> str:
        value = self.program.outputs[target]
        place = self.reach.given(target)
        if self._is_clock(target):
            return f"{indent}{place} = {self._count(value, target[1], named)};\n"
        text = self._real(value, named)
        if target in self.reach.types:
            text = f"({self.reach.types[target]})(int32_t){text}"
        return f"{indent}{place} = {text};\n"

    # -- clocks --------------------------------------------------------------------------------------------------

    def _stays(self, target: Group) -> bool:
        return target[0] == NEXT_STATE and is_own(self.program, self.program.outputs[target], target[1])

    def _readable(self, needs: Mapping[Group, set[int]]) -> frozenset[Group]:
        """Outputs from which a computed number can be read back: no clocks, logical values, codes or delay lines."""
        return frozenset(
            target
            for target in needs
            if target[0] in (NEXT_STATE, OUTPUT)
            and self.program.outputs[target] not in self._whole
            and target not in self.reach.types
            and not self._is_clock(target)
        )

    def _is_clock(self, target: Group) -> bool:
        return target[0] == NEXT_STATE and target[1] in self.clocks

    def _count(self, index: int, position: int, named: dict[int, str]) -> str:
        operation, own = self.program.operations[index], self.reach.given((NEXT_STATE, position))
        if operation.name in ("select", "if"):
            first = self._count(operation.arguments[1], position, named)
            other = self._count(operation.arguments[2], position, named) if operation.name == "select" else "0U"
            return f"({self._truth(operation.arguments[0], named)} ? {first} : {other})"
        more = added(self.program, index, position)
        if more is not None:
            asked = "" if more.condition is None else f"{self._truth(more.condition, named)} && "
            # The count saturates, because an overflow would restart the clock.
            return f"(({asked}({own} < UINT32_MAX)) ? ({own} + 1U) : {own})"
        return own if is_own(self.program, index, position) else "0U"

    def _needed(self, target: Group) -> set[int]:
        """Values that the store of an output uses; for a clock, the conditions on which its next count depends."""

        def conditions(index: int) -> set[int]:
            operation = self.program.operations[index]
            more = added(self.program, index, target[1])
            if more is not None and more.condition is not None:
                return {more.condition}
            if operation.name not in ("select", "if"):
                return set()
            return {operation.arguments[0]}.union(*map(conditions, operation.arguments[1:]))

        value = self.program.outputs[target]
        return conditions(value) if self._is_clock(target) else {value}
