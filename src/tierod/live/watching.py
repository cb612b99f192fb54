"""Problems of a drive, each reported once, and signals that fall silent and come again, each time."""

from __future__ import annotations

from collections.abc import Iterable

from tierod.live.events import Hub


class Watching:
    """Messages about the drive that were sent.

    Args:
        hub: takes what is said
    """

    def __init__(self, hub: Hub):
        self._hub = hub
        self._said: set[str] = set()
        self._missing: dict[str, None] = {}

    def begin(self) -> None:
        """A drive begins: nothing was reported yet."""
        self._said.clear()
        self._missing = {}

    def once(self, key: str, text: str) -> None:
        """Report a problem, once in a drive.

        Args:
            key: of the problem
            text: a sentence with its remedy
        """
        if key not in self._said:
            self._said.add(key)
            self._hub.say("problem", {"text": text})

    def missing(self, names: Iterable[str], time: float) -> None:
        """Report the signals that do not come any more, and those that come again.

        Args:
            names: of those that do not come now
            time: of the drive [s]
        """
        now = dict.fromkeys(names)
        for name in now.keys() - self._missing.keys():
            text = f"{name} does not come any more; what needs it is not judged"
            self._hub.say("problem", {"time": time, "signal": name, "text": text})
        for name in self._missing.keys() - now.keys():
            self._hub.say("signal", {"time": time, "signal": name, "text": f"{name} comes again"})
        self._missing = now
