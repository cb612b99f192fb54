"""Sessions of one monitor for vehicles whose parameters are moved, side by side over the same pieces."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.graph.lanes import FEWEST, SideBySide
from tierod.core.graph.printer import LANES
from tierod.core.graph.trace import Interface
from tierod.core.recording import Aligned
from tierod.monitors.harness.session import BlockSession, Conclusion, Session
from tierod.vehicles.uncertain import moved
from tierod.vehicles.vehicle import Vehicle

REFUSALS = (TierodError, ArithmeticError, np.linalg.LinAlgError)
"""What a monitor raises where it cannot run with a vehicle."""

LANES_FROM = 400_000
"""Steps of moved vehicles in this process from which they run side by side: to print and load a further kernel takes
as long as this saves in as many, and to compile it where no cache has it takes long."""

AT_ONCE = 2_500
"""Samples at once from which they may: a live drive, whose pieces have two seconds, must not wait for a compiler."""

_STEPS: WeakKeyDictionary[Interface, int] = WeakKeyDictionary()
"""Steps of moved vehicles in this process so far, by the graph of their block; no result depends on them."""

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
        self._lanes = SideBySide()
        for place, by in enumerate(moves):
            try:
                session = open_(moved(vehicle, by))
            except REFUSALS:
                continue
            if isinstance(session, BlockSession):
                session.moved, session.pictured = True, False
            self.running[place] = Point(by, session)

    def fit_as(self, session: Session) -> None:
        """Fit blocks that are fitted to a recording like that of the vehicle as it is, so that only parameters differ.

        Args:
            session: for the vehicle as it is, after its first piece
        """
        if not isinstance(session, BlockSession) or session.fitted is None:
            return
        for place in list(self.running):
            with self._refusing(place):
                moved_one = self.running[place].session
                assert isinstance(moved_one, BlockSession)
                moved_one.refit(session.fitted)

    def absorb(self, aligned: Aligned) -> dict[int, Mapping[str, np.ndarray]]:
        """Take in one more piece: traces by place of the vehicle."""
        shown: dict[int, Mapping[str, np.ndarray]] = {}
        for places in self._together(len(aligned.time)):
            shown.update(self._abreast(places, aligned) if len(places) >= FEWEST else self._alone(places, aligned))
        return {place: shown[place] for place in sorted(shown)}

    def _together(self, count: int) -> list[tuple[int, ...]]:
        """Places of vehicles whose blocks run side by side over so many samples, or alone."""
        groups: dict[object, list[int]] = {}
        for place, point in self.running.items():
            session = point.session
            graph = session.stepped if isinstance(session, BlockSession) and count >= AT_ONCE else None
            if graph is not None:
                _STEPS[graph] = _STEPS.get(graph, 0) + count
            groups.setdefault(place if graph is None or _STEPS[graph] < LANES_FROM else graph, []).append(place)
        return [tuple(each[at : at + LANES]) for each in groups.values() for at in range(0, len(each), LANES)]

    def _alone(self, places: Sequence[int], aligned: Aligned) -> Iterator[tuple[int, Mapping[str, np.ndarray]]]:
        for place in places:
            with self._refusing(place):
                yield place, self.running[place].session.absorb(aligned)

    def _abreast(self, places: tuple[int, ...], aligned: Aligned) -> Iterator[tuple[int, Mapping[str, np.ndarray]]]:
        """What `absorb` of each session gives, to the last bit."""
        ready: dict[int, tuple[BlockSession, Aligned]] = {}
        for place in places:
            session = self.running[place].session
            with self._refusing(place):
                assert isinstance(session, BlockSession)
                ready[place] = session, session.prepared(aligned)
        if not ready:
            return
        sessions, given = zip(*ready.values(), strict=True)
        blocks, memories = ([getattr(each, name) for each in sessions] for name in ("block", "memory"))
        results = self._lanes.scan(blocks, given, memories)
        for (place, (session, piece)), result in zip(ready.items(), results, strict=True):
            with self._refusing(place):
                yield place, session.taken(piece, result)

    @contextmanager
    def _refusing(self, place: int) -> Iterator[None]:
        """Leave a vehicle out from now on that its monitor refuses."""
        try:
            yield
        except REFUSALS:
            del self.running[place]

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
