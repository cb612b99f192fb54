"""Count of lost frames, and detection of messages that fell silent, from the learnt period of every message."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.io.readers.frames import Frames, identifier_text, messages

_SETTLING = 20
"""Number of gaps between frames after which the learnt period is used."""

_SPREAD, _MOST = 0.3, 0.7
"""Relative spread around the median gap, and the share of gaps that must lie within it for a message to be periodic;
lost frames are counted for periodic messages only, not for bursts.
"""

NAMED = 4
"""Number of messages named in a sentence about messages that fell silent together."""


@dataclass
class _Message:
    """Newest stamp [s], learnt period [s], and number of gaps seen of one message."""

    newest: float
    period: float = math.nan
    seen: int = 0


@dataclass(frozen=True)
class Gap:
    """Silence of a message that has returned."""

    identifier: int
    bus: str
    seconds: Annotated[float, "s"]


def sentences(gaps: Iterable[Gap]) -> list[str]:
    """One sentence per bus on the messages that fell silent, however many they are."""
    of_bus: dict[str, list[Gap]] = {}
    for gap in gaps:
        of_bus.setdefault(gap.bus, []).append(gap)
    found = []
    for bus, silent in of_bus.items():
        names = [identifier_text(gap.identifier) for gap in silent]
        some = ", ".join(names[:NAMED]) + f" and {len(names) - NAMED} more" * (len(names) > NAMED)
        found.append(f"{some} on {bus}: not received for {max(gap.seconds for gap in silent):.2g} s")
    return found


class Gaps:
    """Learns the period of every message, and counts the frames that are missing.

    Args:
        silence: gap beyond which a message has fallen silent, as during the restart of a control unit
        factor: gap in periods beyond which a frame counts as lost
    """

    def __init__(self, silence: Annotated[float, "s"] = 1.0, factor: float = 1.8):
        self.silence, self.factor = silence, factor
        self.lost = 0
        self._messages: dict[tuple[str, int], _Message] = {}

    def add(self, frames: Frames) -> list[Gap]:
        """Add frames in the order of time, and return the silences that ended among them."""
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
            # Bounded: the only gap of a short piece may be a dropout, which would stretch the learnt period.
            known.period = usual if known.seen < _SETTLING else 0.9 * known.period + 0.1 * min(usual, 2 * known.period)
            known.seen += len(gaps)
            if known.seen < _SETTLING or known.period > self.silence / 3.0:
                continue
            regular = float(np.mean(np.abs(gaps - usual) < _SPREAD * usual)) > _MOST
            wide = gaps[gaps > self.factor * known.period]
            if regular:
                # Delayed frames are followed by shorter gaps; these are not counted as lost.
                crowded = int(np.count_nonzero(gaps < known.period / self.factor))
                missed = int(np.round(wide[wide <= self.silence] / known.period - 1.0).sum())
                self.lost += max(missed - crowded, 0)
            found += [Gap(identifier, name, float(gap)) for gap in wide[wide > self.silence]]
        return found
