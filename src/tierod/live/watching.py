"""Problems of a drive, each reported once, and signals that fall silent and return, reported each time."""

from __future__ import annotations

from collections.abc import Iterable

from tierod.live.events import Hub


class Watching:
    """Keeps track of the messages sent about a drive.

    Args:
        hub: receives the messages
    """

    def __init__(self, hub: Hub):
        self._hub = hub
        self._said: set[str] = set()
        self._missing: dict[str, None] = {}

    def begin(self) -> None:
        """Forget all reports at the beginning of a drive."""
        self._said.clear()
        self._missing = {}

    def once(self, key: str, text: str) -> None:
        """Report a problem once per drive.

        Args:
            key: key that identifies the problem
            text: a sentence with its remedy
        """
        if key not in self._said:
            self._said.add(key)
            self._hub.say("problem", {"text": text})

    def missing(self, names: Iterable[str], time: float) -> None:
        """Report signals that have fallen silent, and signals that have returned.

        Args:
            names: signals that are missing now
            time: time in the drive [s]
        """
        now = dict.fromkeys(names)
        for name in now.keys() - self._missing.keys():
            text = f"{name} is no longer received; monitors that need it do not judge"
            self._hub.say("problem", {"time": time, "signal": name, "text": text})
        for name in self._missing.keys() - now.keys():
            self._hub.say("signal", {"time": time, "signal": name, "text": f"{name} is received again"})
        self._missing = now
