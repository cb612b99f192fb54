"""Patterns for file names: wildcards and regular expressions, matched by RE2 in a time linear in the name's length."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from tierod.core.errors import ParameterError

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


def matches(name: str, pattern: str) -> bool:
    """Whether a whole name matches a pattern: "*" and "?" stay within a folder, "**/" means any number of folders."""
    return _wildcards(pattern, "").fullmatch(name) is not None


def fits(name: str, pattern: str) -> bool:
    """Whether a name, or its end from some folder on, matches a pattern; arguments and errors as of `matches`."""
    return _wildcards(pattern, "(?:.*/)?").fullmatch(name) is not None


@lru_cache(maxsize=256)
def regular(pattern: str) -> Any:
    """A regular expression with the methods of `re.Pattern`, in the syntax of RE2."""
    # A native library, imported where it is needed.
    import re2

    options = re2.Options()
    options.log_errors = False
    try:
        return re2.compile(pattern, options)
    except UnicodeEncodeError:
        raise ParameterError(f"the pattern {pattern!r} is not Unicode text; save the file as UTF-8") from None
    except re2.error as error:
        reason = error.args[0].decode("utf-8", "replace")
        raise ParameterError(
            f"'{pattern}' is not a regular expression of RE2 ({reason}); write it without look-around (?=, ?!, ?<), "
            "back-references (\\1) and possessive repetition (*+), and repeat at most 1000 times"
        ) from None


@lru_cache(maxsize=256)
def _wildcards(pattern: str, before: str) -> Any:
    try:
        return regular("(?s)" + before + "".join(map(_translated, _PARTS.findall(pattern))))
    except ParameterError:
        raise ParameterError(f"the pattern '{pattern}' has a range that is none; write one such as [a-z]") from None


def _translated(part: str) -> str:
    fixed = {"**/": r"(?:[^/]+/)*", "**": r".*", "*": r"[^/]*", "?": r"[^/]"}
    if part in fixed:
        return fixed[part]
    if len(part) > 1:
        return part.replace("\\", "\\\\").replace("[!", "[^")
    return re.escape(part)
