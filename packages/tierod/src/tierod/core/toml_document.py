"""A TOML file that has been read, and the line of each of its keys, which the standard parser does not give."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from tierod.core.errors import ParameterError
from tierod.core.files import expanded
from tierod.core.user_files import read_text, toml

_TOKEN = re.compile(
    r"""(?P<skip>[ \t\r]+|\#[^\n]*)
      | (?P<end>\n)
      | (?P<string>\"{3}(?:\\.|[^\\])*?\"{3,5}(?!\")|'{3}.*?'{3,5}(?!')|"(?:\\.|[^"\\\n])*"|'[^'\n]*')
      | (?P<mark>[\[\]{},=.])
      | (?P<bare>[^\s\#\[\]{},=."']+)""",
    re.VERBOSE | re.DOTALL,
)

Location = Sequence[str | int]  # Keys and indices of array elements, outermost first


def line_of(text: str, location: Location) -> int | None:
    """The line of a key, or of the innermost table that holds it where the key itself is absent; None if neither is."""
    known = _lines(text)
    parts = [str(part) for part in location]
    for length in range(len(parts), 0, -1):
        line = known.get(".".join(parts[:length]))
        if line is not None:
            return line
    return None


@lru_cache(maxsize=16)
def _lines(text: str) -> dict[str, int]:
    return _Scan(text).lines


class _Scan:
    """One pass over a document; `lines` holds the line of every table, key and array element by dotted name."""

    def __init__(self, text: str):
        self.tokens = list(_tokens(text))
        self.at = 0
        self.lines: dict[str, int] = {}
        self.counts: dict[str, int] = {}
        table: tuple[str, ...] = ()
        while (token := self.peek()) is not None:
            if token[0] == "end":
                self.at += 1
            elif token[1] == "[":
                table = self.heading()
            else:
                self.pair(table)

    def peek(self) -> tuple[str, str, int] | None:
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    def take(self, *wanted: str) -> bool:
        token = self.peek()
        found = token is not None and token[1] in wanted
        self.at += found
        return found

    def key(self) -> tuple[str, ...]:
        parts = [self.word()]
        while self.take("."):
            parts.append(self.word())
        return tuple(parts)

    def word(self) -> str:
        kind, text, _ = self.tokens[self.at]
        self.at += 1
        return str(tomllib.loads(f"key = {text}")["key"]) if kind == "string" else text

    def note(self, path: tuple[str, ...], line: int) -> None:
        for length in range(1, len(path) + 1):
            self.lines.setdefault(".".join(path[:length]), line)

    def heading(self) -> tuple[str, ...]:
        """`[table]` or `[[array of tables]]`; an array along the path stands for its latest element."""
        line = self.tokens[self.at][2]
        self.take("[")
        several = self.take("[")
        path: tuple[str, ...] = ()
        key = self.key()
        for position, part in enumerate(key):
            path = (*path, part)
            name = ".".join(path)
            if several and position == len(key) - 1:
                self.counts[name] = self.counts.get(name, -1) + 1
            if name in self.counts:
                path = (*path, str(self.counts[name]))
        while self.take("]"):
            pass
        # A heading is the line of its table, even where the heading of a nested table came first.
        self.lines[".".join(path)] = line
        self.note(path, line)
        return path

    def pair(self, table: tuple[str, ...]) -> None:
        line = self.tokens[self.at][2]
        path = (*table, *self.key())
        self.note(path, line)
        self.take("=")
        self.value(path)

    def value(self, path: tuple[str, ...]) -> None:
        """A value; inline tables and arrays are scanned too."""
        if self.take("{"):
            while not self.take("}"):
                if not self.take(",", "\n"):
                    self.pair(path)
        elif self.take("["):
            count = 0
            while not self.take("]"):
                if not self.take(",", "\n"):
                    element = (*path, str(count))
                    self.note(element, self.tokens[self.at][2])
                    self.value(element)
                    count += 1
        else:
            self.plain()

    def plain(self) -> None:
        while (token := self.peek()) is not None and token[0] != "end" and token[1] not in (",", "]", "}"):
            self.at += 1


def _tokens(text: str) -> Iterator[tuple[str, str, int]]:
    line = 1
    for found in _TOKEN.finditer(text):
        kind = found.lastgroup or ""
        if kind != "skip":
            yield kind, found[0], line
        line += found[0].count("\n")


@dataclass(frozen=True)
class Document:
    content: dict[str, Any]
    text: str
    path: Path
    above: tuple[Path, ...] = ()  # files that refer to this one, outermost first

    @classmethod
    def read(cls, path: str | Path, what: str = "scenario") -> Document:
        text = read_text(path, f"the {what} file", ParameterError, "give a TOML file")
        return cls.parse(text, expanded(path), what)

    @classmethod
    def parse(cls, text: str, path: str | Path = "text", what: str = "scenario") -> Document:
        """The document that a text holds; arguments and errors as for `read`."""
        return cls(toml(text, path, ParameterError, f"no {what} can be read from it"), text, Path(path))

    def beside(self, path: str | Path, what: str) -> Document:
        if "\0" in str(path):
            raise ParameterError(f"{self.path}: the name of a {what} file has a zero character; leave it out")
        found = self.path.parent / expanded(path)
        above = (*self.above, self.path.resolve())
        if found.resolve() in above:
            raise ParameterError(f"the {what} file {found} is built on itself; name another one there")
        return dataclasses.replace(Document.read(found, what), above=above)

    def error(self, location: Location, message: str) -> ParameterError:
        """An error that names the file and the line of a key, or of the table that should hold it."""
        line = line_of(self.text, location)
        return ParameterError(f"{self.path}{'' if line is None else f', line {line}'}: {message}")
