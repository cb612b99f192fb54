"""Text for a terminal: control characters, and letters that the encoding lacks, are printed as escapes."""

from __future__ import annotations

import codecs
import contextlib
import re
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

UNSHOWN = "tierod.unshown"
"""Name of the way in which streams spell out letters that their encoding lacks."""

_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def visible(text: str) -> str:
    """The text with control characters, turns of the writing direction and half characters spelt out as \\u001b.

    Line ends and tabs stay. JSON reads what is spelt out as the characters themselves.
    """
    return _STEERING.sub(lambda found: _spelt(found[0]), text)


def say(text: str, end: str = "\n") -> None:
    """Print a text to stdout, with control characters as escapes."""
    print(visible(text), end=end)


def spell_what_cannot_be_shown() -> None:
    """Let stdout and stderr spell out the letters that their encoding lacks; else printing them would be an error."""
    codecs.register_error(UNSHOWN, _spell)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):  # replaced by another object
            stream.reconfigure(errors=UNSHOWN)  # type: ignore[union-attr]


def console(stderr: bool, width: int | None) -> Console:
    """A console that prints control characters of texts as escapes.

    Args:
        stderr: whether it prints there
        width: in characters; None for that of the terminal
    """
    from rich.console import Console
    from rich.segment import Segment

    class _Console(Console):
        # Every way of printing ends here, also those of libraries.
        def _render_buffer(self, buffer):  # type: ignore[no-untyped-def]
            shown = (part if part.control else Segment(visible(part.text), part.style) for part in buffer)
            return super()._render_buffer(shown)

    return _Console(stderr=stderr, highlight=False, width=width)


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_spelt, error.object[error.start : error.end])), error.end


def _spelt(letter: str) -> str:
    units = letter.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{units[place : place + 2].hex()}" for place in range(0, len(units), 2))
