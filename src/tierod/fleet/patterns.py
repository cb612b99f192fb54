"""Wildcard patterns for file names, with the same meaning for local folders and remote storages."""

from __future__ import annotations

import re
from functools import lru_cache

MAGIC = re.compile(r"[*?\[]")
"""Characters that make a name a pattern."""

_PARTS = re.compile(r"\*\*/|\*\*|\*|\?|\[!?[^]/]+\]|.", re.DOTALL)


def is_pattern(name: str) -> bool:
    """Whether a name holds a wildcard."""
    return MAGIC.search(name) is not None


def folder_of(pattern: str) -> str:
    """The folder above the first wildcard; "" if there is none."""
    found = MAGIC.search(pattern)
    return pattern[: found.start() if found else None].rpartition("/")[0]


@lru_cache(maxsize=256)
def expression(pattern: str) -> re.Pattern[str]:
    """Regular expression of a pattern: "*" and "?" stay within a folder, "**/" matches any number of folders or none.

    Args:
        pattern: pattern with "/" between folders
    """
    return re.compile("".join(map(_translated, _PARTS.findall(pattern))) + r"\Z", re.DOTALL)


def _translated(part: str) -> str:
    fixed = {"**/": r"(?:[^/]+/)*", "**": r".*", "*": r"[^/]*", "?": r"[^/]"}
    if part in fixed:
        return fixed[part]
    if len(part) > 1:
        return part.replace("\\", "\\\\").replace("[!", "[^")
    return re.escape(part)


def fits(name: str, pattern: str) -> bool:
    """Whether a name, or its end from some folder on, matches a pattern.

    Args:
        name: path or address
        pattern: pattern with "/" between folders
    """
    shaped = expression(pattern)
    return bool(shaped.match(name)) or any(
        shaped.match(name, place + 1) for place, letter in enumerate(name) if letter == "/"
    )
