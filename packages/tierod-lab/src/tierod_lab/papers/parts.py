"""The parts of a study, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

from tierod.core.content import Item
from tierod_lab.studies.effort import Effort, Progress


def items_of(package: str, parts: Mapping[str, str], effort: Effort, progress: Progress) -> Iterator[Item]:
    """Items of all parts; each part is imported when its turn comes.

    Args:
        package: package of the study below `tierod_lab.papers`
        parts: subject of every part, by name of its module
        progress: called with the completed share of the parts and the subject of the next part
    """
    for done, (name, title) in enumerate(parts.items()):
        progress(done / len(parts), title)
        part: Callable[[Effort], Iterator[Item]] = import_module(f"tierod_lab.papers.{package}.{name}").items
        yield from part(effort)
