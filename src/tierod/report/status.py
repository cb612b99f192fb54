"""How a status looks: a word, a symbol and a colour, so that nothing depends on colour alone."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.core.findings import Diagnosis, Status


@dataclass(frozen=True)
class Appearance:
    """Looks of a status.

    Args:
        symbol: one character that tells it apart without colour
        kind: class name in the page: good, watch, bad, open
        colour: of text on white, contrast at least 4.5 to 1
        style: of the terminal
    """

    symbol: str
    kind: str
    colour: str
    style: str


_GOOD = Appearance("✓", "good", "#17692f", "bold green")
_WATCH = Appearance("▲", "watch", "#8a5a00", "bold yellow")
_BAD = Appearance("✕", "bad", "#b3261e", "bold red")
_OPEN = Appearance("?", "open", "#475569", "bold cyan")

_APPEARANCES = {
    Status.HEALTHY: _GOOD,
    Status.RISING: _WATCH,
    Status.SUSPECT: _WATCH,
    Status.FAULT: _BAD,
}


def appearance(status: Status) -> Appearance:
    """How this status is shown; whatever is no judgement looks open."""
    return _APPEARANCES.get(status, _OPEN)


def overall(diagnosis: Diagnosis) -> Status:
    """The status of the decisive finding, which stands first; "not available" where no monitor ran."""
    return diagnosis.findings[0].status if diagnosis.findings else Status.NOT_AVAILABLE
