"""Seeds of the drives that a study reports: a block of numbers chosen by the digest of the judged monitor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from tierod.core.block import Block
from tierod.core.content import Table
from tierod.core.errors import ParameterError, nearest
from tierod_lab.campaign.code import reported_seed

APART = 100_000  # Seeds in a block. Seeds below this number were driven while tierod was tuned and are never reported.

BLOCKS = 10_000  # Number of blocks; a change of the monitor selects another one


@dataclass(frozen=True)
class ReportedSeeds:
    """Seeds of a study: the block of the judged monitor, and where every part of the study begins in it."""

    # function that builds the judged graph blocks, with the parameters of the vehicle file as shipped
    judged: Callable[[], Sequence[Block]]
    parts: Mapping[str, int]  # offset of the first seed of every part in the block, by subject of the part
    drawn_by: str  # name of the judged monitor in the printed table

    @cached_property
    def first(self) -> int:
        """First seed of the block."""
        return APART * (1 + reported_seed(*self.judged()) % BLOCKS)

    def of(self, part: str, count: int) -> range:
        """Seeds of a part.

        Args:
            part: one of `parts`

        Raises:
            ParameterError: there is no such part, or the seeds reach beyond the block
        """
        if part not in self.parts:
            raise ParameterError(f"the study has no part '{part}'{nearest(part, self.parts)}")
        begin = self.parts[part]
        if not 0 <= begin <= begin + count <= APART:
            raise ParameterError(f"{part}: {count} seeds from {begin} on do not fit into a block of {APART}")
        return range(self.first + begin, self.first + begin + count)

    def table(self) -> Table:
        """Table of the first seed of every part, as the study prints it."""
        rows = tuple((part, f"{self.first + begin}") for part, begin in self.parts.items())
        return Table(
            "Seeds of the reported drives",
            ("part", "first seed"),
            rows,
            f"The first {len(str(self.first)) - 5} digits follow from the digest of {self.drawn_by}, traced graph and "
            "tuning: whoever changes a threshold or an equation draws other drives. The drives of a part count on from "
            f"its first seed. Seeds below {APART} were driven while tierod was tuned; none of them is reported.",
        )
