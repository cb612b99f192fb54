"""Registry of the studies, which studies.toml lists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from tierod.core.content import Item
from tierod.core.toml import Document
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.metrics import Frame


@dataclass(frozen=True)
class Study:
    """A study that `tierod study` runs, of the package below `tierod_lab.papers` that has its name."""

    name: str  # name on the command line
    title: str  # subject, in a few words
    summary: str  # subject, in one sentence
    # title of every group of claims, by the first part of their keys, in the order of display
    groups: Mapping[str, str]

    def items(self, effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
        """Run the study and yield its claims, tables and charts one after the other."""
        study = import_module(f"tierod_lab.papers.{self.name.replace('-', '_')}.study")
        yield from study.items(effort, progress)


STUDIES: Mapping[str, Study] = {
    each["name"]: Study(**each) for each in Document.read(Path(__file__).with_name("studies.toml")).content["study"]
}
"""All studies by name, as given on the command line."""
