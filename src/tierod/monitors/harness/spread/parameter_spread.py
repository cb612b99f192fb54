"""The spread of a vehicle's parameters over one recording, beside the session for the vehicle as its file gives it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.recording import Aligned
from tierod.monitors.harness.decision import Decision
from tierod.monitors.harness.session import Session
from tierod.monitors.harness.spread.directions import Direction, Sensitivities
from tierod.monitors.harness.spread.points import Concluded, Open, Points, part_of
from tierod.monitors.harness.spread.shown import AFTER, Pair, moved, pairs_of, widened
from tierod.vehicles.vehicle import Vehicle

REACH = 2.0
"""Standard deviations by which parameters are moved together along a direction: the ends of a 95 % band."""

SHORTEST, LONGEST = 20.0, 300.0
"""Stretch over which every parameter is moved alone [s]: as long as all of them together cost as much as one run over
the recording, and long enough for an estimator to settle and a car to turn."""

PATIENCE = 2.0
"""The stretch becomes so many times longer where the result is not known for half of it []."""

MOST_SAMPLES = 100_000
"""Samples of that stretch at the most: ten seconds of a motor at 10 kHz."""

FEW, MANY = 2, 4
"""Directions carried at the most through a long recording, and through one hardly longer than the stretch."""

BLOCK = 3000
"""Samples that are taken in at once."""


class Main(NamedTuple):
    """The result by which the directions are chosen.

    Args:
        pair: value and deviation; the deviation is "" where the value is compared with a threshold
        level: that threshold; 0 where there is a deviation
    """

    pair: Pair
    level: float


class Outcome(NamedTuple):
    """What the moved vehicles gave.

    Args:
        alone: conclusions for vehicles with one parameter moved by one standard deviation, by name of the parameter;
            empty where the recording was longer than the stretch
        along: directions, and the conclusions for vehicles moved along them, both ways as far as there is one
        moves: root mean square of the result's move by each parameter over the stretch, in its own deviations []
        deviation: root mean square of the result's move over the recording, in its unit; 0 without one
        held: share of the recorded truths that the wider band holds; None without truth
        unit: of the result
    """

    alone: Mapping[str, Concluded]
    along: Sequence[tuple[Direction, Sequence[Concluded]]]
    moves: Mapping[str, float]
    deviation: float
    held: float | None
    unit: str


class ParameterSpread:
    """Runs a monitor for vehicles whose parameters are moved within their spread, over the pieces of a recording.

    Args:
        open_: opens a session of the monitor for a vehicle
        vehicle: with the standard deviation of its parameters
        names: of the parameters that the monitor reads and that have one
        session: for the vehicle as it is
        decisions: of the monitor
        rate: of the samples [Hz]
        duration: of the recording, as far as it is known
    """

    def __init__(
        self,
        open_: Open,
        vehicle: Vehicle,
        names: Sequence[str],
        session: Session,
        decisions: Sequence[Decision],
        rate: float,
        duration: Annotated[float, "s"],
    ):
        self.vehicle, self.names, self._open, self._rate = vehicle, tuple(names), open_, rate
        self._pairs, self._main = pairs_of(session.traces), main_result(session, decisions)
        self._unit = session.traces[self._main.pair.value] if self._main else ""
        stretch = min(max(duration / max(len(names), 1), SHORTEST), LONGEST) * rate
        self._stretch = int(min(stretch, MOST_SAMPLES))
        self._most = FEW if duration * rate > 2.0 * PATIENCE * self._stretch else MANY
        self._alone: Points | None = Points(open_, vehicle, [{name: 1.0} for name in self.names])
        self._sensitivities = Sensitivities(self.names)
        self._along: Points | None = None
        self._directions: tuple[Direction, ...] = ()
        self._buffer: list[Aligned] = []
        self._seen = 0
        self._moved, self._known = 0.0, 0
        self._held, self._compared = 0, 0

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Take in one more piece, and give its traces with wider bands.

        Args:
            aligned: the piece
            shown: its traces for the vehicle as it is
        """
        count, done = len(aligned.time), 0
        variances = {pair.value: np.zeros(count) for pair in self._pairs}
        while self._alone is not None and done < count:
            part = slice(done, min(done + BLOCK, count))
            of_part = {name: values[part] for name, values in shown.items()}
            self._screen(
                part_of(aligned, part.start, part.stop), of_part, {name: v[part] for name, v in variances.items()}
            )
            done = part.stop
            if self._enough:
                self._choose()
                if not self._directions:
                    variances = {}
        if self._along is not None and done < count:
            tail = {name: values[done:] for name, values in shown.items()}
            self._carry(part_of(aligned, done, count), tail, {name: v[done:] for name, v in variances.items()})
        wide = widened(shown, variances, self._pairs) if variances else dict(shown)
        self._compare(wide, variances)
        return wide

    def reopen(self, alone: bool, along: Sequence[Mapping[str, float]]) -> None:
        """Open the vehicles of a checkpoint, to be filled with what they collected.

        Args:
            alone: whether the stretch lasts in which every parameter is moved alone
            along: standard deviations by parameter, of every vehicle that is moved along a direction
        """
        self._alone = self._alone if alone else None
        self._along = Points(self._open, self.vehicle, along) if along else None

    @property
    def _enough(self) -> bool:
        """Whether the stretch has been long enough; it has no end where there is no result to be moved on the way."""
        if self._main is None:
            return False
        return self._sensitivities.known >= self._stretch or self._seen >= PATIENCE * self._stretch

    def _screen(self, aligned: Aligned, shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """A block of the stretch: every parameter moved alone."""
        assert self._alone is not None
        self._seen += len(aligned.time)
        self._buffer.append(aligned)
        others = self._alone.absorb(aligned)
        for other in others.values():
            for name, variance in variances.items():
                variance += moved(shown, other, name) ** 2
        if self._main is None:
            return
        known, scale = _known(shown, self._main)
        moves = np.zeros((len(self.names), int(known.sum())))
        for place, other in others.items():
            moves[place] = moved(shown, other, self._main.pair.value)[known] / scale[known]
        self._sensitivities.add(moves)

    def _choose(self) -> None:
        """The end of the stretch: only directions go on, and catch up with it."""
        self._alone = None
        self._open_directions()

    def _open_directions(self) -> None:
        self._directions = self._sensitivities.directions(self._most) if self._sensitivities.known else ()
        if self._directions:
            ways = [
                {name: side * REACH * part for name, part in each.by.items()}
                for each in self._directions
                for side in (1.0, -1.0)
            ]
            self._along = Points(self._open, self.vehicle, ways)
            for block in self._buffer:
                self._along.absorb(block)
        self._buffer = []

    def _carry(self, aligned: Aligned, shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """What follows on the stretch: all parameters moved along the directions."""
        assert self._along is not None
        others = self._along.absorb(aligned)
        captured = sum(each.share for each in self._directions)
        for name, variance in variances.items():
            for place in range(len(self._directions)):
                sides = [others[at] for at in (2 * place, 2 * place + 1) if at in others]
                squares = [(moved(shown, other, name) / REACH) ** 2 for other in sides]
                if squares:
                    variance += np.mean(squares, axis=0) / captured

    def _compare(self, wide: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """Follow how far the result moved, and whether its band holds a truth."""
        if self._main is None or not self._main.pair.deviation:
            return
        value, deviation = (wide[name] for name in self._main.pair)
        known = np.isfinite(value) & np.isfinite(deviation)
        if variances:
            self._moved += float(np.sum(variances[self._main.pair.value][known]))
        self._known += int(known.sum())
        truth = wide.get(f"true_{self._main.pair.value}")
        if truth is not None:
            both = known & np.isfinite(truth)
            self._compared += int(both.sum())
            self._held += int(np.sum(np.abs(value - truth)[both] <= 1.96 * deviation[both]))

    def conclude(self) -> Outcome:
        """What the moved vehicles gave, over all pieces."""
        alone: dict[str, Concluded] = {}
        if self._alone is not None:
            alone = {self.names[place]: each for place, each in self._alone.conclude().items()}
            self._open_directions()
        found = self._along.conclude() if self._along is not None else {}
        along = [
            (each, [found[at] for at in (2 * place, 2 * place + 1) if at in found])
            for place, each in enumerate(self._directions)
        ]
        return Outcome(
            alone,
            along,
            self._sensitivities.moves() if self._sensitivities.known else {},
            (self._moved / self._known) ** 0.5 if self._known else 0.0,
            self._held / self._compared if self._compared else None,
            self._unit,
        )


def main_result(session: Session, decisions: Sequence[Decision]) -> Main | None:
    """The result of a session by which its spread is judged: its first with a band, else what it first decides by.

    Args:
        session: of a monitor
        decisions: of the monitor
    """
    after = [each for each in pairs_of(session.traces) if each.deviation.endswith(AFTER)]
    if after:
        return Main(after[0], 0.0)
    for each in decisions:
        if each.statistic in session.traces and each.levels and np.isfinite(each.levels[0]) and each.levels[0] != 0.0:
            return Main(Pair(each.statistic, ""), abs(each.levels[0]))
    return None


def _known(shown: Mapping[str, np.ndarray], main: Main) -> tuple[np.ndarray, np.ndarray]:
    """Where the result is known and was being learnt, and what its moves are held against, (n,) each."""
    value = shown[main.pair.value]
    scale = shown[main.pair.deviation] if main.pair.deviation else np.full(len(value), main.level)
    known = np.isfinite(value) & np.isfinite(scale) & (scale > 0.0)
    enabled = shown.get("enabled")
    return (known if enabled is None else known & (enabled > 0.5)), scale
