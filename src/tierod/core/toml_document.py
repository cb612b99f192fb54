"""A TOML file that has been read, with the lines of its keys for messages."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import ParameterError
from tierod.core.files import expanded
from tierod.core.toml_lines import Location, line_of
from tierod.core.user_files import read_text, toml


@dataclass(frozen=True)
class Document:
    """A TOML file that has been read.

    Args:
        content: its tables
        text: as written
        path: where it came from
        above: files that led here, outermost first
    """

    content: dict[str, Any]
    text: str
    path: Path
    above: tuple[Path, ...] = ()

    @classmethod
    def read(cls, path: str | Path, what: str = "scenario") -> Document:
        """The document at a path.

        Args:
            path: of the file
            what: it should describe, for messages

        Raises:
            ParameterError: it cannot be read, or is not TOML
        """
        text = read_text(path, f"the {what} file", ParameterError, "give a TOML file")
        return cls.parse(text, expanded(path), what)

    @classmethod
    def parse(cls, text: str, path: str | Path = "text", what: str = "scenario") -> Document:
        """The document that a text holds; arguments and errors as of `read`."""
        return cls(toml(text, path, ParameterError, f"no {what} can be read from it"), text, Path(path))

    def beside(self, path: str | Path, what: str) -> Document:
        """The document at a path that this one names, from its own folder on.

        Args:
            path: of the file
            what: it should describe, for messages

        Raises:
            ParameterError: it cannot be read, is not TOML, or leads back to itself
        """
        if "\0" in str(path):
            raise ParameterError(f"{self.path}: the name of a {what} file has a zero character; leave it out")
        found = self.path.parent / expanded(path)
        above = (*self.above, self.path.resolve())
        if found.resolve() in above:
            raise ParameterError(f"the {what} file {found} is built on itself; name another one there")
        return dataclasses.replace(Document.read(found, what), above=above)

    def error(self, location: Location, message: str) -> ParameterError:
        """An error that names the file and the line of a key, or of the table that should hold it.

        Args:
            location: tables, numbers of array elements and key, outermost first
            message: what was given, what was expected, what to do
        """
        line = line_of(self.text, location)
        return ParameterError(f"{self.path}{'' if line is None else f', line {line}'}: {message}")
