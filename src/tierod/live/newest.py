"""Newest value of every signal with its time stamp, updated frame by frame."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from tierod.live.bound import bound
from tierod.live.frame import Frame

if TYPE_CHECKING:
    from tierod.io.readers.dbc import Described
    from tierod.io.readers.mapping import Pick

Key = tuple[str, int]
"""Name of a bus, and identifier."""

KEPT = 64
"""Past samples kept of a signal from which others are derived: more than the span of a recipe at 100 Hz."""

Made = Callable[[bytes], float | None]


class Newest:
    """Updates values from frames in the order of time; `values` and `times` [s] hold the newest of every wired signal.

    `places` gives the index of a signal by name, and `past` the past samples (time [s], value) of selected signals.
    """

    def __init__(self) -> None:
        self.places: dict[str, int] = {}
        self.values: list[float] = []
        self.times: list[float] = []
        self.past: dict[str, deque[tuple[float, float]]] = {}
        self._actions: dict[Key, list[tuple[int, Made, deque[tuple[float, float]] | None]]] = {}

    def wire(self, known: Described, buses: Mapping[int, str], picks: Iterable[Pick], kept: Sequence[str] = ()) -> None:
        """Select the signals that are decoded from the frames; values received before are kept.

        Args:
            known: description of the frames by the databases
            buses: names of the buses by their number in `known`
            picks: how canonical signals are made from columns; one with columns of several messages is skipped
            kept: signals whose past samples are kept
        """
        self._actions = {}
        for pick in {each.name: each for each in picks}.values():
            found = [known.places[column] for column in pick.columns if column in known.places]
            keys = {key for key, _ in found}
            if len(found) != len(pick.columns) or len(keys) != 1:
                continue
            ((bus, identifier),) = keys
            message = known.found[bus, identifier].message
            place = self._place(pick.name)
            if pick.name in kept:
                self.past.setdefault(pick.name, deque(maxlen=KEPT))
            made = _made(pick, [bound(message, item) for _, item in found])
            action = (place, made, self.past.get(pick.name))
            self._actions.setdefault((buses[bus], identifier), []).append(action)

    def _place(self, name: str) -> int:
        if name not in self.places:
            self.places[name] = len(self.values)
            self.values.append(math.nan)
            self.times.append(-math.inf)
        return self.places[name]

    def take(self, frame: Frame) -> None:
        """Update values from the next frame; a frame older than the newest value of its signal is ignored."""
        for place, made, past in self._actions.get((f"CAN{frame.bus}", frame.identifier), ()):
            if frame.time < self.times[place]:
                continue
            value = made(frame.data)
            if value is not None:
                self.times[place], self.values[place] = frame.time, value
                if past is not None:
                    past.append((frame.time, value))


def _made(pick: Pick, parts: Sequence[Made]) -> Made:
    """Conversion of a payload into a canonical signal, by the same operations as `tierod.io.readers.making`."""
    first, *others = parts
    gain, offset, scale = pick.entry.sign * pick.entry.factor, pick.entry.offset, pick.scale

    def made(data: bytes) -> float | None:
        value = first(data)
        for part in others:
            more = part(data)
            value = None if value is None or more is None else value + more
        if value is None:
            return None
        value = gain * value if gain != 1.0 else value
        value = float(scale(value + offset if offset else value))
        return math.nan if math.isinf(value) else value

    return made
