"""Makes a failing file small: what is not needed for the same failure goes, or becomes zero."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

from .corpus import pack
from .fuzz import attempt, class_of
from .pool import Pool, Result
from .targets import Case

TRIES = 1500
"""Files that are tried at the most; a tenth where each costs a process."""


def minimised(each: Case) -> tuple[Case, Result]:
    """The case with as little content as found, and its result.

    Args:
        each: a case that fails
    """
    with Pool() as pool:
        result = attempt(pool, each)
        wanted = class_of(result)
        left = TRIES if result.code is not None else TRIES // 10

        def fails(content: bytes) -> bool:
            nonlocal left
            left -= 1
            return class_of(attempt(pool, replace(each, content=content))) == wanted

        content = each.content
        for shorter, reserve in ((True, left // 2), (False, 0)):
            content = _shrunk(content, shorter, fails, lambda reserve=reserve: left > reserve)
        return replace(each, content=content), result


def _shrunk(content: bytes, shorter: bool, fails: Callable[[bytes], bool], more: Callable[[], bool]) -> bytes:
    """Blocks go, or become zero, ever smaller ones; from the end, so that what headers say stays true if it can."""
    size = max(len(content) // 2, 1)
    while size and more():
        for begin in range((len(content) - 1) // size * size, -1, -size):
            block = content[begin : begin + size]
            if not more():
                break
            if not shorter and not block.strip(b"\0"):
                continue
            candidate = content[:begin] + (b"" if shorter else bytes(len(block))) + content[begin + size :]
            if fails(candidate):
                content = candidate
        size //= 2
    return content


def entry(each: Case, result: Result) -> str:
    """The case as the corpus keeps it.

    Args:
        each: minimised
        result: of it
    """
    lines = ["[[case]]", 'name = ""', f"why = {json.dumps(class_of(result))}", f"command = {json.dumps(each.command)}"]
    lines += [f"file = {json.dumps(each.name)}"]
    try:
        text = each.content.decode("utf-8")
        plain = len(text) < 600 and not any(ord(sign) < 32 and sign not in "\n\t" for sign in text)
    except UnicodeDecodeError:
        plain = False
    lines += [f"text = {json.dumps(text)}" if plain else f"packed = {json.dumps(pack(each.content))}", "expected = [3]"]
    return "\n".join(lines) + "\n"
