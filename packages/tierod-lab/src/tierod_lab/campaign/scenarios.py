"""Scenarios of the points of a matrix, with changes and faults applied, and checked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from tierod.core.errors import ParameterError
from tierod.core.toml import quoted
from tierod.core.toml_document import Document
from tierod_lab.campaign.matrix import CampaignFile, Level, Point, with_changes
from tierod_lab.ground import scenarios
from tierod_lab.ground.faults import Fault
from tierod_lab.ground.scenarios import Scenario, require_fault_free

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(content: Mapping[str, object]) -> str:
    """A TOML document, one line per key of the top level, with inline tables."""
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in content.items())


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else quoted(key)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0.0 else "-inf"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise TypeError(f"{value!r} cannot be written as TOML")


@dataclass
class Scenes:
    """Builds the scenarios of a campaign; each combination of levels is built and checked once for all seeds."""

    file: CampaignFile
    document: Document
    base: Document  # base scenario of all drives
    _made: dict[tuple[str, ...], Scenario] = field(default_factory=dict)

    @classmethod
    def of(cls, file: CampaignFile, document: Document) -> Scenes:
        given = file.scenario
        beside = document.path.parent / given
        try:
            base = scenarios.load(beside if beside.is_file() else given)
        except ParameterError as error:
            raise document.error(("scenario",), str(error)) from None
        if base.faults:
            raise document.error(
                ("scenario",), f"the scenario '{base.name}' has faults itself; a campaign brings its own: take them out"
            )
        return cls(file, document, base.document)

    def scenario(self, point: Point) -> Scenario:
        place = tuple(label for level in point.levels for label in level.place.values())
        if place not in self._made:
            try:
                self._made[place] = self._built(point.changes(self.file.changes), point.faults, point.tables)
            except ParameterError as error:
                raise self._blamed(point, error) from None
        return self._made[place].with_run(seed=point.seed)

    def _blamed(self, point: Point, error: ParameterError) -> ParameterError:
        message = str(error)
        if message.startswith(f"{self.document.path}, line"):
            return error
        for path, value in self.file.changes.items():
            if alone := self._refused({path: value}, ()):
                return self.document.error(("changes", path), self._bare(alone))
        for level in point.levels:
            if alone := self._refused({**self.file.changes, **level.changes}, level.faults):
                return self.document.error(level.location, f"{_called(level)}: {self._bare(alone)}")
        names = ", ".join(_called(level) for level in point.levels)
        return self.document.error(("axes",), f"{names}: {self._bare(message)}")

    def _bare(self, message: str) -> str:
        return message.removeprefix(f"{self.base.path}: ")

    def _refused(self, changes: Mapping[str, object], faults: tuple[Fault, ...]) -> str:
        try:
            self._built(changes, faults)
        except ParameterError as error:
            return str(error)
        return ""

    def _built(
        self, changes: Mapping[str, object], faults: tuple[Fault, ...], tables: Sequence[Mapping[str, object]] = ()
    ) -> Scenario:
        content = with_changes(self.base.content, changes)
        # An empty text keeps lines of the base scenario out of messages about the campaign's changes.
        made = scenarios.from_document(Document(content, "", self.base.path))
        whole = {**content, "faults": list(tables)} if tables else content
        described = Document(whole, toml_text(whole), self.base.path)
        driven = replace(made, faults=faults, document=described)
        require_fault_free(driven)
        return driven


def _called(level: Level) -> str:
    return ", ".join(f"{axis} '{label}'" for axis, label in level.place.items() if label)
