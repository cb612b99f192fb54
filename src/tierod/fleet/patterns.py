"""Names of files with wildcards, the same for folders of this machine and for storages elsewhere."""

from __future__ import annotations

import re
from functools import lru_cache

MAGIC = re.compile(r"[*?\[]")
"""What makes a name a pattern."""

_PARTS = re.compile(r"\*\*/|\*\*|\*|\?|\[!?[^]/]+\]|.", re.DOTALL)


def is_pattern(name: str) -> bool:
    """Whether a name holds a wildcard."""
    return MAGIC.search(name) is not None


def folder_of(pattern: str) -> str:
    """The folder above the first wildcard; "" where that is none."""
    found = MAGIC.search(pattern)
    return pattern[: found.start() if found else None].rpartition("/")[0]


@lru_cache(maxsize=256)
def expression(pattern: str) -> re.Pattern[str]:
    """The regular expression of a pattern: "*" and "?" stay in a folder, "**/" is any folders, none included.

    Args:
        pattern: with "/" between folders
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
    """Whether a name, or its end from some folder on, fits a pattern.

    Args:
        name: path or address
        pattern: with "/" between folders
    """
    shaped = expression(pattern)
    return bool(shaped.match(name)) or any(
        shaped.match(name, place + 1) for place, letter in enumerate(name) if letter == "/"
    )
