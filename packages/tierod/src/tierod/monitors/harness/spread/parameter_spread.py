"""Effect of the spread of a vehicle's parameters over one recording, beside the session for the unperturbed vehicle.

All decisions here depend on the samples alone: not on the length of the recording, which is unknown in a live drive,
and not on how it is cut into pieces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.recording import Aligned
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
"""Shortest and longest stretch over which each parameter is perturbed alone [s]: the shortest one lets an estimator
settle and a car turn."""

LATER, COST = 2.0, 2.0
"""Length of a later stretch [-]: `LATER` first stretches, since its sessions begin in motion, or, if that is longer, so
much that all its sessions together cost `COST` runs over the driving so far."""

PATIENCE = 2.0
"""Longest stretch, in multiples of its length, if the result is unknown for part of the time [-]."""

UNMOVED = 5.0
"""Longest first stretch, in multiples of its length, if no parameter changes the result [-]."""

MOST_SAMPLES = 100_000
"""Most samples of a stretch: ten seconds of a motor at 10 kHz."""

AGAIN, GROWTH, SOONER = 4.0, 3.0, 1.5
"""When parameters are perturbed alone again [-]: after `AGAIN` first stretches of driving, then at `GROWTH` times the
driving so far; at `SOONER` times the driving so far while no parameter changes the result."""

KEPT = 0.8
"""Share of the variance from which the previous directions are kept [-]."""

FEW, MANY = 2, 4
"""Largest number of directions: through a long recording, and until the second stretch has ended."""

BLOCKS = 4
"""Blocks of a first stretch; decisions are made only at the end of a block."""

SPAN = 3000
"""Most samples that are processed at once while each parameter is perturbed alone."""


class Outcome(NamedTuple):
    """Results of the perturbed vehicles.

    Args:
        alone: conclusions for vehicles with one parameter perturbed by one standard deviation, by name of the
            parameter; empty if the recording was longer than the first stretch
        along: directions, each with the conclusions for the vehicles perturbed along it with either sign
        moves: root mean square of the result's change by each parameter over a stretch, in standard deviations of the
            result [-]
        deviation: root mean square of the result's change over the recording [unit of the result]; 0 without one
        held: share of the samples with a recorded true value that the wider band contains; None without true values
        unit: unit of the result
        reference: conclusion of the unperturbed session that began with the directions; None if they began with the
            recording
    """

    alone: Mapping[str, Concluded]
    along: Sequence[tuple[Direction, Sequence[Concluded]]]
    moves: Mapping[str, float]
    deviation: float
    held: float | None
    unit: str
    reference: Conclusion | None = None


class ParameterSpread:
    """Runs a monitor for vehicles with parameters perturbed within their spread, over the pieces of a recording.

    Args:
        open_: function that opens a session of the monitor for a vehicle
        vehicle: vehicle with the standard deviations of its parameters
        names: names of the uncertain parameters that the monitor reads
        session: session for the unperturbed vehicle
        decisions: decisions of the monitor
        rate: sampling rate [Hz]
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
        points = Points(self._open, self.vehicle, moves_alone(self.names, fresh))
        points.fit_as(self._session)
        return Screen(points, self.names, self._main, length, self._block, fresh)

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Process one more piece and return its traces with wider bands.

        Args:
            aligned: next piece
            shown: traces of the piece for the unperturbed vehicle
        """
        # `session` has absorbed this first piece already, and has fitted its block to it if it needs a fit.
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
        """End of the samples that are processed at once: the end of the first block at which something is decided."""
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
        """At the end of a block, end a stretch that is long enough, or begin the next one if it is due."""
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
        """Samples of a later stretch; short while no parameter changes the result, since it is repeated sooner then."""
        if self._carried is None:
            return self._stretch
        length = min(max(COST * self._driven / len(self.names), LATER * self._stretch), LONGEST * self._rate)
        return int(min(length, MOST_SAMPLES))

    def _end(self, screen: Screen) -> None:
        """End a stretch: only the sessions along directions continue, after processing its samples."""
        self._screen = None
        self._follow(screen)
        if self._carried is None:
            due = SOONER * self._driven
        else:
            due = GROWTH * self._driven if screen.fresh else AGAIN * self._stretch
        self._next = max(int(due), self._driven + 1)

    def _follow(self, screen: Screen) -> None:
        """Choose the directions to be followed from the effects of the parameters over a stretch."""
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
        """Accumulate the variance of the result, and how often its wider band contains the true value."""
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
        """Results of the perturbed vehicles over all pieces."""
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
