"""The spread of a vehicle's parameters over one recording, beside the session for the vehicle as its file gives it.

Everything here depends on the samples alone: never on the length of the recording, which is unknown in a live drive,
and never on how it comes in pieces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.recording import Aligned
from tierod.core.series import Rows
from tierod.monitors.harness.decision import Decision
from tierod.monitors.harness.session import Conclusion, Session
from tierod.monitors.harness.spread.block_sum import BlockSum
from tierod.monitors.harness.spread.carried import Carried, moves_along
from tierod.monitors.harness.spread.directions import Direction, Sensitivities
from tierod.monitors.harness.spread.main_result import main_result, where_known
from tierod.monitors.harness.spread.points import Concluded, Open, Points, part_of
from tierod.monitors.harness.spread.screen import Screen, moves_alone
from tierod.monitors.harness.spread.shown import moved, pairs_of, widened
from tierod.vehicles.vehicle import Vehicle

SHORTEST, LONGEST = 20.0, 300.0
"""Stretch over which every parameter is moved alone [s]: long enough for an estimator to settle and a car to turn."""

LATER, COST = 2.0, 2.0
"""A later stretch is so many times longer than the first one, since its sessions begin in motion, and as long as all of
them together cost so many runs up to it []."""

PATIENCE = 2.0
"""The stretch becomes so many times longer where the result is not known for half of it []."""

UNMOVED = 5.0
"""The first stretch becomes so many times longer where nothing moves the result []."""

MOST_SAMPLES = 100_000
"""Samples of a stretch at the most: ten seconds of a motor at 10 kHz."""

AGAIN, GROWTH, SOONER = 4.0, 3.0, 1.5
"""After so many first stretches of driving parameters are moved alone again, then after so many times the driving; and
after so many times where nothing moves the result yet []."""

KEPT = 0.8
"""Share of the variance at which the directions of before are kept."""

FEW, MANY = 2, 4
"""Directions that are followed at the most through a long recording, and up to the second stretch."""

BLOCKS = 4
"""Blocks of a first stretch, at whose ends is decided."""

SPAN = 3000
"""Samples that are taken in at once while every parameter is moved alone."""


class Outcome(NamedTuple):
    """Results of the moved vehicles.

    Args:
        alone: conclusions for vehicles with one parameter moved by one standard deviation, by name of the parameter;
            empty where the recording was longer than the first stretch
        along: directions, and the conclusions for vehicles moved along them, both ways as far as there is one
        moves: root mean square of the result's move by each parameter over a stretch, in its own deviations []
        deviation: root mean square of the result's move over the recording, in its unit; 0 without one
        held: share of the recorded truths that the wider band holds; None without truth
        unit: of the result
        reference: conclusion of the session that began with the directions, where they began within the recording
    """

    alone: Mapping[str, Concluded]
    along: Sequence[tuple[Direction, Sequence[Concluded]]]
    moves: Mapping[str, float]
    deviation: float
    held: float | None
    unit: str
    reference: Conclusion | None = None


class ParameterSpread:
    """Runs a monitor for vehicles whose parameters are moved within their spread, over the pieces of a recording.

    Args:
        open_: opens a session of the monitor for a vehicle
        vehicle: with the standard deviation of its parameters
        names: of the parameters that the monitor reads and that have one
        session: for the vehicle as it is
        decisions: of the monitor
        rate: of the samples [Hz]
    """

    def __init__(
        self,
        open_: Open,
        vehicle: Vehicle,
        names: Sequence[str],
        session: Session,
        decisions: Sequence[Decision],
        rate: Annotated[float, "Hz"],
    ):
        self.vehicle, self.names, self._open, self._rate = vehicle, tuple(names), open_, rate
        self._session = session
        self._pairs, self._main = pairs_of(session.traces), main_result(session, decisions)
        self._unit = session.traces[self._main.pair.value] if self._main else ""
        self._stretch = int(min(SHORTEST * rate, MOST_SAMPLES))
        self._block = max(self._stretch // BLOCKS, 1)
        self._screen: Screen | None = self._screened(self._stretch, fresh=False)
        self._carried: Carried | None = None
        self._sensitivities = Sensitivities(self.names)
        self._seen = self._driven = 0
        self._next = int(AGAIN * self._stretch)
        self._moved, self._known = BlockSum(), 0
        self._held, self._compared = 0, 0

    def _screened(self, length: int, fresh: bool) -> Screen:
        with Rows.growing():
            points = Points(self._open, self.vehicle, moves_alone(self.names, fresh))
            points.fit_as(self._session)
        return Screen(points, self.names, self._main, length, self._block, fresh)

    def reopen(self, alone: Sequence[Mapping[str, float]], along: Sequence[Mapping[str, float]]) -> None:
        """Open the vehicles of a checkpoint, to be filled with their state.

        Args:
            alone: standard deviations by parameter, of every vehicle of a stretch that lasts; empty without one
            along: of every vehicle that is moved along a direction; empty without one
        """
        own, others = (Points(self._open, self.vehicle, each) for each in (alone, along))
        self._screen = Screen(own, self.names, self._main, 0, self._block, False) if alone else None
        self._carried = Carried(others, (), False) if along else None

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Take in one more piece, and give its traces with wider bands.

        Args:
            aligned: the piece
            shown: its traces for the vehicle as it is
        """
        if not self._seen and self._screen is not None:
            self._screen.points.fit_as(self._session)
        count, done = len(aligned.time), 0
        variances = {pair.value: np.zeros(count) for pair in self._pairs}
        known = np.zeros(count, bool) if self._main is None else where_known(shown, self._main)
        while done < count:
            stop = self._stop(known, done)
            part = slice(done, stop)
            self._take(
                part_of(aligned, done, stop),
                {name: values[part] for name, values in shown.items()},
                {name: each[part] for name, each in variances.items()},
            )
            self._driven += int(known[part].sum())
            self._seen += stop - done
            done = stop
            if self._seen % self._block == 0:
                self._look()
        wide = widened(shown, variances, self._pairs)
        self._compare(wide, variances)
        return wide

    def _stop(self, known: np.ndarray, done: int) -> int:
        """End of the samples that are taken in at once: the first block at whose end something is decided."""
        ends = np.arange(done + self._block - self._seen % self._block, len(known) + 1, self._block)
        counts = np.cumsum(known[done:])[ends - done - 1] if len(ends) else np.zeros(0, int)
        screen = self._screen
        if self._main is None:
            ends = ends[:0]
        elif screen is None:
            ends = ends[self._driven + counts >= self._next]
        else:
            long = screen.seen + ends - done >= PATIENCE * screen.length
            ends = ends[(screen.known + counts >= screen.length) | long]
        stop = int(ends[0]) if len(ends) else len(known)
        return stop if screen is None else min(stop, done + SPAN)

    def _take(self, aligned: Aligned, shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        others = self._screen.absorb(aligned, shown) if self._screen is not None else {}
        if self._carried is not None:
            self._carried.absorb(aligned, shown, variances)
        elif self._screen is not None and not self._screen.fresh:
            for other in others.values():
                for name, variance in variances.items():
                    variance += moved(shown, other, name) ** 2

    def _look(self) -> None:
        """A block is whole: end a stretch that was long enough, and begin another one where it is due."""
        screen = self._screen
        if screen is None:
            if self._main is not None and self._driven >= self._next:
                self._screen = self._screened(self._length(), fresh=True)
            return
        if self._main is not None and (screen.known >= screen.length or screen.seen >= PATIENCE * screen.length):
            unmoved = not screen.fresh and not screen.sensitivities.any_counted
            if not unmoved or screen.seen >= UNMOVED * screen.length:
                self._end(screen)

    def _length(self) -> int:
        """Samples of a later stretch: of a short one where nothing moves the result yet, since it comes more often."""
        if self._carried is None:
            return self._stretch
        length = min(max(COST * self._driven / len(self.names), LATER * self._stretch), LONGEST * self._rate)
        return int(min(length, MOST_SAMPLES))

    def _end(self, screen: Screen) -> None:
        """The end of a stretch: only directions go on, and catch up with it."""
        self._screen = None
        self._follow(screen)
        if self._carried is None:
            due = SOONER * self._driven
        else:
            due = GROWTH * self._driven if screen.fresh else AGAIN * self._stretch
        self._next = max(int(due), self._driven + 1)

    def _follow(self, screen: Screen) -> None:
        """Choose the parameters to follow from now on by their effects over a stretch."""
        found = screen.sensitivities
        if not found.any_counted:
            self._sensitivities = self._sensitivities if self._sensitivities.known else found
            return
        self._sensitivities = found
        if self._carried is not None:
            shares = found.shares(self._carried.followed)
            if sum(sorted(shares.values())[-FEW:]) >= KEPT:
                self._carried.fit(shares, FEW)
                return
        directions = found.directions(FEW if screen.fresh else MANY)
        points = Points(self._open, self.vehicle, moves_along(directions, screen.fresh))
        points.fit_as(self._session)
        self._carried = Carried(points, directions, screen.fresh)
        self._carried.catch_up(screen.buffer)

    def _compare(self, wide: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """Follow how far the result moved, and whether its band holds a truth."""
        if self._main is None or not self._main.pair.deviation:
            return
        value, deviation = (wide[name] for name in self._main.pair)
        known = np.isfinite(value) & np.isfinite(deviation)
        self._moved.add(np.where(known, variances[self._main.pair.value], 0.0))
        self._known += int(known.sum())
        truth = wide.get(f"true_{self._main.pair.value}")
        if truth is not None:
            both = known & np.isfinite(truth)
            self._compared += int(both.sum())
            self._held += int(np.sum(np.abs(value - truth)[both] <= 1.96 * deviation[both]))

    def conclude(self) -> Outcome:
        """Results of the moved vehicles, over all pieces."""
        alone: dict[str, Concluded] = {}
        screen, self._screen = self._screen, None
        if screen is not None:
            screen.close_block()
            if not screen.fresh:
                alone = screen.conclude()
            if not screen.fresh or screen.known >= screen.length // 2:
                self._follow(screen)
        along, reference = self._carried.conclude() if self._carried is not None else ([], None)
        return Outcome(
            alone,
            along,
            self._sensitivities.moves() if self._sensitivities.known else {},
            (self._moved.value / self._known) ** 0.5 if self._known else 0.0,
            self._held / self._compared if self._compared else None,
            self._unit,
            reference,
        )
