"""Resolution of sensors, estimated as the smallest step between two of their readings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, both, minimum, present, where

UNIFORM = 1.0 / 12.0
"""Variance of a rounding error, uniform over one step, over the square of the step."""


class SmallestSteps(NamedTuple):
    """Last reading of every sensor, and its smallest change so far.

    The steps of a sensor on a bus may be ten times its noise, and a vehicle file need not give them.

    Args:
        last: last readings; a missing reading keeps the previous one
        smallest: smallest changes above the rounding residue [units of the readings]
    """

    last: tuple[Scalar, ...]
    smallest: tuple[Scalar, ...]

    @classmethod
    def unseen(cls, coarsest: Sequence[float]) -> SmallestSteps:
        """State before the first reading.

        Args:
            coarsest: step of every sensor that is assumed until its readings have shown a smaller one
        """
        return cls((0.0,) * len(coarsest), tuple(coarsest))

    def after(self, readings: Sequence[Scalar], residues: Sequence[float]) -> SmallestSteps:
        """State after one more reading of every sensor.

        Args:
            readings: readings; NaN if missing
            residues: changes that may be rounding residues of arithmetic, see `residue_of`
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
        """Variance that rounding adds to every reading."""
        return tuple(UNIFORM * each * each for each in self.smallest)
