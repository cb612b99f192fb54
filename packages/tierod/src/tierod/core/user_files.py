"""Reading of text files that users give: regular files, bounded in length and nesting, decoded strictly.

    text = read_text("car.toml", "the vehicle file", ParameterError)
    content = toml(text, "car.toml", ParameterError)

Recordings are read by `tierod.io.readers`; JSON in them is parsed by `json_document` as well.
"""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, TierodError
from tierod.core.files import expanded

# Longest TOML file [bytes]: the parser takes about a second for it; the largest that tierod ships has 12 kB
MOST_BYTES = 1 << 20

# Longest JSON, DBC or course file [bytes]: a CAN database of a whole vehicle has a few million
MOST_DATA_BYTES = 1 << 24

# Deepest nesting of tables and lists: parsers recurse once per level, and a dotted key costs the cube of its depth
MOST_DEPTH = 32

_PART = r"""(?:[A-Za-z0-9_-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?:^|[\[{{,])[ \t]*+({_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_DEPTH},}})", re.MULTILINE)

_KINDS = (
    (stat.S_ISDIR, "it is a folder"),
    (stat.S_ISFIFO, "it is a pipe"),
    (stat.S_ISSOCK, "it is a socket"),
    (stat.S_ISCHR, "it is a device"),
    (stat.S_ISBLK, "it is a device"),
)
_NOT_BLOCKING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)


def read_bytes(
    path: str | Path, what: str, error: type[TierodError] = InputError, cure: str = "", most: int = MOST_BYTES
) -> bytes:
    path = expanded(path)
    cure = cure or "check the path and its permissions"
    try:
        # Checked before it is opened: opening a pipe may block, and opening a device may have an effect.
        refusal = _irregular(os.stat(path).st_mode)
        content = b"" if refusal else _content(path, most)
    except (OSError, ValueError) as problem:  # ValueError: a path with a zero byte
        refusal = ((problem.strerror if isinstance(problem, OSError) else None) or str(problem)).lower()
    if refusal:
        raise error(f"{what} {path} cannot be read ({refusal}); {cure}")
    if content is None:
        raise error(f"{what} {path} is longer than {_amount(most)}, which is too long for one; name the right file")
    return content


def read_text(
    path: str | Path,
    what: str,
    error: type[TierodError] = InputError,
    cure: str = "",
    most: int = MOST_BYTES,
    *,
    keep_line_ends: bool = False,
) -> str:
    """The text of a file that a user named, which has to be UTF-8, with or without a byte order mark."""
    content = read_bytes(path, what, error, cure, most)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = content.count(b"\n", 0, problem.start) + 1
        raise error(f"{what} {path} cannot be read (it is not UTF-8 text in line {line}); save it as UTF-8") from None
    return text if keep_line_ends else text.replace("\r\n", "\n").replace("\r", "\n")


def toml(text: str, where: str | Path, error: type[TierodError] = InputError, cure: str = "") -> dict[str, Any]:
    key = _DEEP_KEY.search(text)
    if key is not None:
        line = text.count("\n", 0, key.start(1)) + 1
        raise error(f"{where}, line {line}: the key '{key[1][:40]}...' has {_TOO_DEEP}")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise error(f"{where}: a list or table has {_TOO_DEEP}") from None
    except ValueError as problem:  # a number of more digits than Python converts is none of tomllib's own errors
        raise error(f"{where} is not valid TOML: {problem}; {cure or 'correct it there'}") from None
    if _too_deep(content):
        raise error(f"{where}: a list or table has {_TOO_DEEP}")
    if (place := _too_long(content)) is not None:
        raise error(f"{where}: the whole number at '{place}' {_TOO_LONG}")
    return content


def json_document(text: str | bytes) -> Any:
    try:
        text = text.decode("utf-8-sig") if isinstance(text, bytes) else text
        document = json.loads(text)
        if _too_deep(document):
            raise RecursionError
        if (place := _too_long(document)) is not None:
            raise ValueError(f"the whole number at '{place}' {_TOO_LONG}")
        # Only an escape can give half of a surrogate pair; encoding the document again finds it.
        if r"\ud" in text or r"\uD" in text:
            json.dumps(document, ensure_ascii=False).encode()
    except json.JSONDecodeError as problem:
        raise ValueError(f"it is not JSON from line {problem.lineno} on") from None
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None
    except UnicodeEncodeError:
        raise ValueError("it holds half of a character (a lone surrogate)") from None
    except RecursionError:
        raise ValueError(f"it has {_TOO_DEEP}") from None
    return document


def names_schema(content: str | bytes, schema: str) -> bool:
    """Whether a file, whole or damaged, is a JSON document of a schema of any version."""
    content = content.encode() if isinstance(content, str) else content
    name = re.escape(schema.partition("/")[0].encode())
    content = content.removeprefix(b"\xef\xbb\xbf")
    return content.lstrip().startswith(b"{") and re.search(rb'"schema"\s*:\s*"' + name + b"/", content) is not None


_TOO_DEEP = f"more than {MOST_DEPTH} levels, deeper than anything that tierod reads; name the right file"


_TOO_LONG = "has more than 64 bits; give a number with a decimal point"


def _irregular(mode: int) -> str:
    """Type of a file that is not regular, as a half-sentence; "" for a regular one."""
    if stat.S_ISREG(mode):
        return ""
    return next((words for test, words in _KINDS if test(mode)), "it is not a regular file")


def _content(path: Path, most: int) -> bytes | None:
    """The bytes of a regular file; None where there are more than allowed."""
    with open(os.open(path, os.O_RDONLY | _NOT_BLOCKING), "rb") as file:
        status = os.fstat(file.fileno())
        if refusal := _irregular(status.st_mode):  # replaced after it was checked
            raise OSError(0, refusal)
        # Some files of the system, such as those in /proc, state the size zero whatever they hold.
        content = file.read(most + 1) if status.st_size <= most else None
    return content if content is not None and len(content) <= most else None


def _too_deep(document: object) -> bool:
    return len(list(islice(_levels(document), MOST_DEPTH + 2))) > MOST_DEPTH + 1


def _too_long(document: object) -> str | None:
    """Key of a whole number that does not fit into 64 bits, and perhaps into no float; None where all do."""
    numbers = (pair for level in _levels(document) for pair in level if isinstance(pair[1], int))
    return next((name[:80] for name, number in numbers if number.bit_length() > 64), None)


def _levels(document: object) -> Iterator[list[tuple[str, Any]]]:
    """(dotted key, value) of all entries of a document, level by level; an entry of a list has the key of the list."""
    level = [("", document)]
    while level:
        yield level
        level = [pair for name, each in level for pair in _entries(name, each)]


def _entries(name: str, value: object) -> list[tuple[str, object]]:
    if isinstance(value, dict):
        return [(f"{name}.{key}".lstrip("."), each) for key, each in value.items()]
    return [(name, each) for each in value] if isinstance(value, list) else []


def _amount(count: int) -> str:
    return f"{count >> 20} MiB" if count >= 1 << 20 else f"{count} bytes"
