"""Glossary of a page: signals, parameters and terms, each explained once at the end of the page and linked."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.core.statuses import SEVERITY, Status
from tierod.report.charts.figure import Figure
from tierod.report.display import words
from tierod.vehicles import QUANTITIES

TIMED = "Drag to zoom, double-click for everything; all charts over time follow, and so does their cursor."
UNTIMED = "Drag to zoom, double-click for everything."


class Glossary:
    """Explanations that a page has requested, in that order.

    Attributes:
        found: name and explanation of each, by its identifier on the page
    """

    def __init__(self) -> None:
        self.found: dict[str, tuple[str, str]] = {}

    def link(self, text: object) -> Any:
        import markupsafe

        known = explanation(str(text))
        return self._word(known, text) if known else markupsafe.escape(text)

    def status(self, text: object) -> Any:
        """The word of a status, as a link to its explanation."""
        import markupsafe

        if text not in SEVERITY:
            return markupsafe.escape(text)
        status = Status(str(text))
        return self._word((words(status), status.meaning), status)

    def chart(self, figure: Figure) -> Any:
        reading = " ".join(filter(None, (figure.caption, figure.reading, TIMED if figure.timed else UNTIMED)))
        looks = f'class="term info" aria-label="How to read: {_attribute(figure.title)}"'
        return self._linked(f"read-{figure.name}", (figure.title, reading), looks, "i")

    def _word(self, known: tuple[str, str], text: object) -> Any:
        """A link; only the first occurrence of a word is in the tab order of the keyboard."""
        identifier = f"word-{_slug(known[0])}"
        return self._linked(identifier, known, 'class="term"' + ' tabindex="-1"' * (identifier in self.found), text)

    def _linked(self, identifier: str, known: tuple[str, str], looks: str, text: object) -> Any:
        import markupsafe

        self.found.setdefault(identifier, known)
        name = _attribute(identifier)
        return markupsafe.Markup(f'<a href="#{name}" aria-describedby="{name}" {looks}>{markupsafe.escape(text)}</a>')


def explanation(text: str) -> tuple[str, str] | None:
    """(name, explanation) of a signal, a parameter or a term; None for an unknown text."""
    return _known().get(re.sub(r"\s*\[[^]]*\]$", "", text).strip().lower())


@cache
def _known() -> dict[str, tuple[str, str]]:
    found = {}
    for quantity in QUANTITIES.values():
        meaning = quantity.meaning[:1].upper() + quantity.meaning[1:]
        found[words(quantity.name).lower()] = (words(quantity.name), f"{meaning}.")
    for signal in SIGNALS.values():
        label = shown(signal.unit)[1]
        sentences = [signal.meaning, *([f"Positive: {signal.positive}."] if signal.positive else [])]
        sentences += [f"Shown in {label}."] if label else []
        found[words(signal.name).lower()] = (words(signal.name), " ".join(sentences))
    text = Path(__file__).with_name("glossary.toml").read_text("utf-8")
    for name, meaning in (term for table in tomllib.loads(text).values() for term in table.items()):
        found[name.lower()] = (words(name), meaning)
    return found


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def _attribute(text: str) -> str:
    import markupsafe

    return str(markupsafe.escape(text))
