"""Sessions of one monitor for vehicles whose parameters are moved, side by side over the same pieces."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.recording import Aligned
from tierod.monitors.harness.session import BlockSession, Conclusion, Session
from tierod.vehicles.uncertain import moved
from tierod.vehicles.vehicle import Vehicle

REFUSALS = (TierodError, ArithmeticError, np.linalg.LinAlgError)
"""What a monitor raises where it cannot run with a vehicle."""

Open = Callable[[Vehicle], Session]


class Concluded(NamedTuple):
    """A conclusion for a vehicle that was moved.

    Args:
        by: standard deviations by name of the parameter []
        conclusion: of its session
    """

    by: Mapping[str, float]
    conclusion: Conclusion


@dataclasses.dataclass
class Point:
    """A session for a vehicle that is moved.

    Args:
        by: standard deviations by name of the parameter []
        session: of the monitor
    """

    by: Mapping[str, float]
    session: Session


class Points:
    """The sessions for several moved vehicles; one that its monitor refuses is left out.

    Args:
        open_: opens a session for a vehicle
        vehicle: with a standard deviation of every parameter that is moved
        moves: standard deviations by name of the parameter, one entry per vehicle
    """

    def __init__(self, open_: Open, vehicle: Vehicle, moves: Sequence[Mapping[str, float]]):
        self.running: dict[int, Point] = {}
        for place, by in enumerate(moves):
            try:
                session = open_(moved(vehicle, by))
            except REFUSALS:
                continue
            if isinstance(session, BlockSession):
                session.moved, session.pictured = True, False
            self.running[place] = Point(by, session)

    def absorb(self, aligned: Aligned) -> dict[int, Mapping[str, np.ndarray]]:
        """Take in one more piece: traces by place of the vehicle."""
        shown = {}
        for place, point in list(self.running.items()):
            try:
                shown[place] = point.session.absorb(aligned)
            except REFUSALS:
                del self.running[place]
        return shown

    def conclude(self) -> dict[int, Concluded]:
        """Conclusions by place of the vehicle."""
        found = {}
        for place, point in self.running.items():
            try:
                found[place] = Concluded(point.by, point.session.conclude())
            except REFUSALS:
                continue
        return found


def part_of(aligned: Aligned, start: int, stop: int) -> Aligned:
    """Samples of a piece.

    Args:
        aligned: the piece
        start, stop: places of its samples
    """
    return Aligned(aligned.time[start:stop], aligned.values[start:stop], aligned.names)
