"""Decoding of frames into signals while they arrive; each identifier is looked up in the databases once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tierod.core.recording import Channel
from tierod.io.readers.dbc import Described, Rows, channel_of, described, silent_channels
from tierod.io.readers.frames import Frames, messages
from tierod.io.readers.log import Heard

if TYPE_CHECKING:
    from cantools.database.can import Message


class Decoder:
    """Registers the identifiers seen on each bus, and decodes those that the databases describe.

    `known` describes the frames seen so far; None until one is in the databases. `version` counts its changes.
    """

    def __init__(self, database: Sequence[Message]):
        self._database = database
        self._counts: dict[tuple[int, int], int] = {}
        self._buses: dict[str, int] = {}
        self.known: Described | None = None
        self.version = 0

    def hear(self, frames: Frames) -> None:
        """Count the frames, and look up identifiers that are new."""
        new = False
        for identifier, bus, rows in messages(frames):
            key = (self._bus(frames, bus), identifier)
            new |= key not in self._counts
            self._counts[key] = self._counts.get(key, 0) + len(rows)
        if new:
            self._look_up()

    def _bus(self, frames: Frames, number: int) -> int:
        return self._buses.setdefault(frames.buses[number], len(self._buses))

    def _look_up(self) -> None:
        from tierod.core.errors import InputError

        heard = Heard(dict(sorted(self._counts.items())), tuple(self._buses), sum(self._counts.values()))
        try:
            found = described(heard, self._database)
        except InputError:
            return
        if self.known is None or found.found.keys() != self.known.found.keys():
            self.known = found
            self.version += 1

    @property
    def buses(self) -> dict[int, str]:
        """Names of the buses by their number in `known`."""
        return {number: name for name, number in self._buses.items()}

    def channels(self, frames: Frames, names: Sequence[str]) -> list[Channel]:
        """Channels of the named columns in some frames; without samples where no frame carries the column."""
        assert self.known is not None
        wanted = self.known.wanted(names)
        found = {}
        for identifier, bus, index in messages(frames):
            key = (self._bus(frames, bus), identifier)
            if key in wanted:
                rows = Rows.of(frames, index)
                entry = self.known.found[key]
                found[key] = [channel_of(name, entry, item, rows) for name, item in wanted[key]]
        channels = []
        for key, items in wanted.items():
            channels += found.get(key) or silent_channels(self.known.found[key], items)
        return channels
