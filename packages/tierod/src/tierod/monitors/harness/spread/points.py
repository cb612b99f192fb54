"""Sessions of one monitor for several vehicles with perturbed parameters, over the same pieces."""

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
"""Exceptions by which a monitor refuses to run with a vehicle."""

LANES_FROM = 400_000
"""Steps of perturbed vehicles in this process from which they run in the lanes of one kernel: printing and loading a
further kernel takes as long as it saves in so many steps, and compiling it without a cache takes much longer."""

AT_ONCE = 2_500
"""Least samples of a piece for the use of lanes: a live drive, with pieces of two seconds, must not wait for a
compiler."""

_STEPS: WeakKeyDictionary[Interface, int] = WeakKeyDictionary()
"""Steps of perturbed vehicles in this process so far, by the graph of their block; no result depends on them."""

Open = Callable[[Vehicle], Session]


class Concluded(NamedTuple):
    """Conclusion for a perturbed vehicle.

    Args:
        by: perturbation in standard deviations by name of the parameter [-]
        conclusion: conclusion of its session
    """

    by: Mapping[str, float]
    conclusion: Conclusion


@dataclasses.dataclass
class Point:
    """Session for a perturbed vehicle.

    Args:
        by: perturbation in standard deviations by name of the parameter [-]
        session: session of the monitor
    """

    by: Mapping[str, float]
    session: Session


class Points:
    """Sessions for several perturbed vehicles; a vehicle that the monitor refuses is left out.

    Args:
        open_: function that opens a session for a vehicle
        vehicle: vehicle with the standard deviations of all perturbed parameters
        moves: perturbation in standard deviations by name of the parameter, one entry per vehicle
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
        """Give blocks that are fitted to a recording the fit of the unperturbed vehicle: only parameters may differ.

        Args:
            session: session for the unperturbed vehicle, after its first piece
        """
        if not isinstance(session, BlockSession) or session.fitted is None:
            return
        for place in list(self.running):
            with self._refusing(place):
                moved_one = self.running[place].session
                assert isinstance(moved_one, BlockSession)
                moved_one.refit(session.fitted)

    def absorb(self, aligned: Aligned) -> dict[int, Mapping[str, np.ndarray]]:
        """Process one more piece and return the traces by index of the vehicle."""
        shown: dict[int, Mapping[str, np.ndarray]] = {}
        for places in self._together(len(aligned.time)):
            shown.update(self._abreast(places, aligned) if len(places) >= FEWEST else self._alone(places, aligned))
        return {place: shown[place] for place in sorted(shown)}

    def _together(self, count: int) -> list[tuple[int, ...]]:
        """Groups of vehicles, by index, whose blocks run in the lanes of one kernel over `count` samples, or alone."""
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
        """Run several sessions in the lanes of one kernel; the result is that of `absorb`, to the last bit."""
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
        """Context in which the refusal of a vehicle removes it."""
        try:
            yield
        except REFUSALS:
            del self.running[place]

    def conclude(self) -> dict[int, Concluded]:
        """Conclusions by index of the vehicle."""
        found = {}
        for place, point in self.running.items():
            try:
                found[place] = Concluded(point.by, point.session.conclude())
            except REFUSALS:
                continue
        return found


def part_of(aligned: Aligned, start: int, stop: int) -> Aligned:
    """Part of a piece.

    Args:
        aligned: piece
        start, stop: indices of its first sample and of the one after its last
    """
    return Aligned(aligned.time[start:stop], aligned.values[start:stop], aligned.names)
