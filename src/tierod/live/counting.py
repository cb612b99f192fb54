"""Frames that were lost, and messages that fell silent, from the periods in which they came before."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.io.readers.frames import Frames, identifier_text, messages

_SETTLING = 20
"""Gaps from which a period is taken."""

_SPREAD, _MOST = 0.3, 0.7
"""A message is periodic, so that lost frames can be counted, where more than this share of its gaps is within the
spread of the median; in bursts nothing is counted."""

NAMED = 4
"""Messages that are named of those that fell silent together."""


@dataclass
class _Message:
    """Newest stamp [s], period [s] as it was learnt, and gaps seen."""

    newest: float
    period: float = math.nan
    seen: int = 0


@dataclass(frozen=True)
class Gap:
    """A message that came again after it had been silent.

    Args:
        identifier: of the message
        bus: name of its bus
        seconds: how long it did not come
    """

    identifier: int
    bus: str
    seconds: Annotated[float, "s"]


def sentences(gaps: Iterable[Gap]) -> list[str]:
    """One sentence for each bus, however many of its messages fell silent.

    Args:
        gaps: that ended together
    """
    of_bus: dict[str, list[Gap]] = {}
    for gap in gaps:
        of_bus.setdefault(gap.bus, []).append(gap)
    found = []
    for bus, silent in of_bus.items():
        names = [identifier_text(gap.identifier) for gap in silent]
        some = ", ".join(names[:NAMED]) + f" and {len(names) - NAMED} more" * (len(names) > NAMED)
        found.append(f"{some} on {bus} did not come for {max(gap.seconds for gap in silent):.2g} s")
    return found


class Gaps:
    """Learns the period of every message, and counts what did not come.

    Args:
        silence: from which on a message has fallen silent, as a restarted control unit does
        factor: gap in periods from which on a frame counts as lost
    """

    def __init__(self, silence: Annotated[float, "s"] = 1.0, factor: float = 1.8):
        self.silence, self.factor = silence, factor
        self.lost = 0
        self._messages: dict[tuple[str, int], _Message] = {}

    def add(self, frames: Frames) -> list[Gap]:
        """The messages that came again after a silence, among frames in the order of time."""
        found = []
        for identifier, bus, rows in messages(frames):
            name, times = frames.buses[bus], frames.time[rows]
            known = self._messages.setdefault((name, identifier), _Message(float(times[0])))
            gaps = np.diff(times, prepend=known.newest)
            gaps = gaps[gaps > 0.0]
            known.newest = float(times[-1])
            if not len(gaps):
                continue
            usual = float(np.median(gaps))
            known.period = usual if known.seen < _SETTLING else 0.9 * known.period + 0.1 * min(usual, 2 * known.period)
            known.seen += len(gaps)
            if known.seen < _SETTLING or known.period > self.silence / 3.0:
                continue
            regular = float(np.mean(np.abs(gaps - usual) < _SPREAD * usual)) > _MOST
            wide = gaps[gaps > self.factor * known.period]
            if regular:
                # Frames that were only delayed come closer together afterwards, and were not lost.
                crowded = int(np.count_nonzero(gaps < known.period / self.factor))
                missed = int(np.round(wide[wide <= self.silence] / known.period - 1.0).sum())
                self.lost += max(missed - crowded, 0)
            found += [Gap(identifier, name, float(gap)) for gap in wide[wide > self.silence]]
        return found
