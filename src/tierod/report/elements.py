"""The states of sensors and actuators as rows of a table, for terminal and page alike."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.findings import Element, Episode
from tierod.report.display import instant, interval, words
from tierod.report.status import Appearance, appearance

COLUMNS = ("sensor or actuator", "state", "fault", "from", "to", "size", "replaced by", "code")


class ElementRow(NamedTuple):
    """One line: of an element without episode, or of one of its episodes.

    Args:
        name: of the element; empty in the lines of its further episodes
        looks: of its status
        status, fault, start, end, size, substitute, code: as shown
    """

    name: str
    looks: Appearance
    status: str
    fault: str
    start: str
    end: str
    size: str
    substitute: str
    code: str

    @property
    def cells(self) -> tuple[str, ...]:
        """In the order of `COLUMNS`."""
        state = f"{self.looks.symbol} {self.status}" if self.status else ""
        return (self.name, state, self.fault, self.start, self.end, self.size, self.substitute, self.code)


def rows(element: Element) -> list[ElementRow]:
    """The lines of one element: at least one, and one for every episode."""
    looks = appearance(element.status)
    if not element.episodes:
        return [
            ElementRow(
                words(element.name), looks, element.status, element.cause, "", "", "", "", element.trouble_code
            )
        ]  # fmt: skip
    lines = []
    for place, episode in enumerate(element.episodes):
        first = place == 0
        lines.append(
            ElementRow(
                words(element.name) if first else "",
                looks,
                element.status if first else "",
                _fault(episode),
                instant(episode.start) if episode.start > 0.0 else "start",
                "end" if episode.end is None else instant(episode.end),
                _size(episode),
                element.substitute if first else "",
                element.trouble_code if first else "",
            )
        )
    return lines


def _fault(episode: Episode) -> str:
    others = " or ".join(words(name).lower() for name in episode.candidates)
    return f"{episode.kind or 'kind not told'}{f'; not told from {others}' if others else ''}"


def _size(episode: Episode) -> str:
    if episode.magnitude is None:
        return ""
    value, low, high, unit = interval(episode.magnitude)
    return f"{value} {unit} ({low} to {high})" if low != "–" else f"{value} {unit}"
