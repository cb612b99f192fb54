"""Steps all monitors tick by tick while frames arrive, in the order of time over all buses."""

from __future__ import annotations

import bisect
import math
import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from tierod.live.newest import Newest
from tierod.live.ticking import Ticker, needed

if TYPE_CHECKING:
    from tierod.io.readers.mapping import Pick
    from tierod.live.decoding import Decoder
    from tierod.live.frame import Frame
    from tierod.live.judge import Judge

_stamp = operator.attrgetter("time")


class Ticks:
    """Tickers of a drive, by name of the monitor.

    Args:
        wait: time that a tick waits for frames of a slower bus
    """

    def __init__(self, wait: Annotated[float, "s"]):
        self.tickers: dict[str, Ticker] = {}
        self._wait = wait
        self._newest = Newest()
        self._wired = -1
        self._held: list[Frame] = []
        self._last: dict[int, float] = {}
        self._until = -math.inf
        self._due = math.inf

    def take(self, frames: Sequence[Frame], latest: float) -> bool:
        """Step every monitor through the ticks that no further frame can change.

        Args:
            frames: new frames, at least one
            latest: newest stamp of the drive [s]

        Returns:
            whether a verdict changed
        """
        for frame in frames:
            self._last[frame.bus] = max(self._last.get(frame.bus, -math.inf), frame.time)
        # A bus that has fallen silent must not hold up the ticks.
        limit = max(min(self._last.values()), latest - self._wait) if len(self._last) > 1 else latest
        self._held += frames
        self._held.sort(key=_stamp)
        ready = len(self._held) if self._held[-1].time <= limit else bisect.bisect_right(self._held, limit, key=_stamp)
        due, take = self._due, self._newest.take
        for frame in self._held[:ready]:
            if frame.time > due:
                due = self._advance(frame.time)
            take(frame)
        if ready:
            self._until = max(self._until, self._held[ready - 1].time)
        self._due = due
        del self._held[:ready]
        changed = [ticker for ticker in self.tickers.values() if ticker.changed]
        for ticker in changed:
            ticker.changed = False
        return bool(changed)

    def _advance(self, until: float) -> float:
        for ticker in self.tickers.values():
            ticker.advance(until)
        return min((ticker.due for ticker in self.tickers.values()), default=math.inf)

    def settle(self, judges: Sequence[Judge], decoder: Decoder, picks: Sequence[Pick], frames: Sequence[Frame]) -> None:
        """Compare the ticks with a judged piece, and begin ticks of monitors that run now.

        Args:
            judges: all monitors
            decoder: decoder of the frames
            picks: how the signals of all monitors are made from columns
            frames: frames of the piece and all received since
        """
        for judge in judges:
            if judge.broken:
                self.tickers.pop(judge.name, None)
            elif judge.name in self.tickers:
                self.tickers[judge.name].settle()
        new = [each for each in judges if each.name not in self.tickers and not each.broken and _suits(each)]
        if new or (self.tickers and self._wired != decoder.version):
            self._begin(new, judges, decoder, picks, frames)

    def _begin(
        self,
        new: Sequence[Judge],
        judges: Sequence[Judge],
        decoder: Decoder,
        picks: Sequence[Pick],
        frames: Sequence[Frame],
    ) -> None:
        """Begin the ticks of some monitors at the end of the piece, and step them through the frames received since."""
        known = decoder.known
        assert known is not None
        runs = [judge.run for judge in judges if judge.run is not None]
        self._newest, self._wired = Newest(), decoder.version
        self._newest.wire(known, decoder.buses, picks, [name for run in runs for name in needed(run)])
        begun = {each.name: Ticker(each.run, self._newest) for each in new if each.run is not None}
        for ticker in begun.values():
            ticker.begin()
        for frame in sorted(frames, key=_stamp):
            if frame.time > self._until:
                break
            for ticker in begun.values():
                ticker.advance(frame.time)
            self._newest.take(frame)
        for judge in new:
            judge.ticker = self.tickers[judge.name] = begun[judge.name]
        for ticker in self.tickers.values():
            ticker.read(self._newest)
        self._due = -math.inf


def _suits(judge: Judge) -> bool:
    return judge.run is not None and judge.run.begun and Ticker.suits(judge.run)
