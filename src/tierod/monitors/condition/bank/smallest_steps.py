"""Resolution of sensors, as their readings show it: the smallest step between two of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, both, minimum, present, where

UNIFORM = 1.0 / 12.0
"""Variance of a rounded value over its step squared."""


class SmallestSteps(NamedTuple):
    """Last reading of every sensor, and its smallest change so far.

    A sensor of a bus reads in steps that may be ten times its noise, and a vehicle file need not state it.

    Args:
        last: readings; one that is missing keeps the one before
        smallest: change that is no rounding residue, in the units of the readings
    """

    last: tuple[Scalar, ...]
    smallest: tuple[Scalar, ...]

    @classmethod
    def unseen(cls, coarsest: Sequence[float]) -> SmallestSteps:
        """Before the first reading.

        Args:
            coarsest: step that is assumed of every sensor until it has shown a smaller one
        """
        return cls((0.0,) * len(coarsest), tuple(coarsest))

    def after(self, readings: Sequence[Scalar], residues: Sequence[float]) -> SmallestSteps:
        """Smallest steps after one more reading of every sensor.

        Args:
            readings: NaN where missing
            residues: changes up to which arithmetic makes them, see `residue_of`
        """
        here = [present(each) for each in readings]
        changes = [
            absolute(where(there, each, before) - before)
            for there, each, before in zip(here, readings, self.last, strict=True)
        ]
        return SmallestSteps(
            tuple(where(there, each, before) for there, each, before in zip(here, readings, self.last, strict=True)),
            tuple(
                where(both(there, change > residue), minimum(change, least), least)
                for there, change, least, residue in zip(here, changes, self.smallest, residues, strict=True)
            ),
        )

    @property
    def variances(self) -> tuple[Scalar, ...]:
        """Variances that rounding adds to every reading."""
        return tuple(UNIFORM * each * each for each in self.smallest)
