"""Every case that ever failed, as small files of TOML: `corpus/*.toml`.

    [[case]]
    name = "units-in-towers"
    why = "pint worked out the power for ever"
    command = ["inspect", "{file}"]
    file = "drive.csv"
    text = "time [s],yaw_rate [m**9**9**9**9]\\n0,1\\n1,2\\n"
    expected = [3]                # exit codes that are right
    says = "unit"                 # stands in what it says, where the words matter

The content is `text`, in which `fill = { "@" = ["[", 1000] }` puts 1000 brackets for each @; `packed`, base64 of zlib;
or `made`, the name of a function of `recipes`.
"""

from __future__ import annotations

import base64
import tomllib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from . import recipes
from .pool import Pool, Result
from .targets import arguments

FOLDER = Path(__file__).parent / "corpus"


@dataclass(frozen=True)
class Kept:
    """A case that failed once.

    Args:
        name: of the case; unique
        why: what went wrong
        command: arguments of tierod, with places for paths
        file: name of the attacked file
        expected: exit codes that are right
        text: of the file
        fill: what takes the place of a mark in the text, and how often
        packed: content of the file, base64 of zlib
        made: function of `recipes` that makes the file
        says: stands in what the command says
        encoding: of the output
        slow: whether it is run by `make attack` alone
    """

    name: str
    why: str
    command: tuple[str, ...]
    file: str
    expected: tuple[int, ...]
    text: str = ""
    fill: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    packed: str = ""
    made: str = ""
    says: str = ""
    encoding: str = "utf-8"
    slow: bool = False

    def write(self, path: Path) -> None:
        """Make the file.

        Args:
            path: of the file
        """
        if self.made:
            getattr(recipes, self.made)(path)
        elif self.packed:
            path.write_bytes(zlib.decompress(base64.b64decode(self.packed)))
        else:
            text = self.text
            for mark, (part, times) in self.fill.items():
                text = text.replace(mark, part * times)
            path.write_bytes(text.encode("utf-8", "surrogateescape"))

    def run(self, pool: Pool) -> Result:
        """Run the case.

        Args:
            pool: that runs it
        """
        folder = pool.folder()
        self.write(folder / self.file)
        return pool.run(arguments(self.command, folder, self.file), self.encoding)

    def fault(self, result: Result) -> str:
        """What is wrong with a result; "" where it is as it should be.

        Args:
            result: of the case
        """
        if result.kind:
            return f"{result.kind}: {result.detail}"
        if result.code not in self.expected:
            return f"exit {result.code}, expected {self.expected}: {result.stderr}"
        if self.says and self.says not in result.stdout + result.stderr:
            return f"does not say '{self.says}': {result.stderr}"
        return ""


def load() -> list[Kept]:
    """All cases of the corpus."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        for entry in tomllib.loads(path.read_text(encoding="utf-8"))["case"]:
            lists = {key: tuple(entry[key]) for key in ("command", "expected")}
            found.append(Kept(**{**entry, **lists}))
    return found
