"""Where a key stands in a TOML text: the standard parser does not tell."""

from __future__ import annotations

import re
from collections.abc import Sequence

_TABLE = re.compile(r"\s*\[+\s*([^\[\]]+?)\s*\]+\s*(#.*)?$")
_KEY = re.compile(r"""\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")


def line_of(text: str, path: Sequence[str]) -> int | None:
    """The line of the key, or of the innermost table that holds it where the key itself is absent; None if neither is.

    Args:
        text: the TOML file
        path: the key with the tables around it, outermost first
    """
    wanted = tuple(path)
    table: tuple[str, ...] = ()
    best, line = 0, None
    for number, row in enumerate(text.splitlines(), 1):
        if heading := _TABLE.match(row):
            here = table = _split(heading[1])
        elif key := _KEY.match(row):
            here = table + _split(key[1])
        else:
            continue
        if here == wanted[: len(here)] and len(here) > best:
            best, line = len(here), number
    return line


def _split(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in re.findall(r"\"[^\"]*\"|'[^']*'|[^.]+", dotted))
