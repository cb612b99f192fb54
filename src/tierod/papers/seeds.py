"""The seeds of every drive that a study reports: one block of numbers, which the judged monitor draws."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from tierod.core.block import Block
from tierod.core.content import Table
from tierod.core.errors import ParameterError, nearest
from tierod.experiments.reported_seed import reported_seed

APART = 100_000
"""Numbers of a block. Those below were driven while tierod was tuned and are never reported."""

BLOCKS = 10_000
"""Of which a change of the monitor draws another one."""


@dataclass(frozen=True)
class ReportedSeeds:
    """Seeds of a study: the first of the judged monitor's block, and where every part begins in it.

    Args:
        judged: makes the blocks that are judged, with the parameters of the vehicle file as it is shipped
        parts: number of the first drive of every part, by what the part is about
        drawn_by: the judged monitor, for the page
    """

    judged: Callable[[], Sequence[Block]]
    parts: Mapping[str, int]
    drawn_by: str

    @cached_property
    def first(self) -> int:
        """The first number of the block."""
        return APART * (1 + reported_seed(*self.judged()) % BLOCKS)

    def of(self, part: str, count: int) -> range:
        """Seeds of a part.

        Args:
            part: in `parts`
            count: how many

        Raises:
            ParameterError: there is no such part, or the seeds leave the block
        """
        if part not in self.parts:
            raise ParameterError(f"the study has no part '{part}'{nearest(part, self.parts)}")
        begin = self.parts[part]
        if not 0 <= begin <= begin + count <= APART:
            raise ParameterError(f"{part}: {count} seeds from {begin} on do not fit into a block of {APART}")
        return range(self.first + begin, self.first + begin + count)

    def table(self) -> Table:
        """The list that the study prints."""
        rows = tuple((part, f"{self.first + begin}") for part, begin in self.parts.items())
        return Table(
            "Seeds of the reported drives",
            ("part", "first seed"),
            rows,
            f"The first {len(str(self.first)) - 5} digits follow from the digest of {self.drawn_by}, traced graph and "
            "tuning: whoever changes a threshold or an equation draws other drives. The drives of a part count on from "
            f"its first seed. Seeds below {APART} were driven while tierod was tuned; none of them is reported.",
        )
