"""Claims as rows of a file: what a study measures, in which rows of which dataset, and what goal the figure has."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any

from tierod.core.claims import Claim, Goal
from tierod.core.content import Chart, Heading, Item, Table
from tierod.core.errors import ParameterError, nearest
from tierod.core.toml import Document, Location
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.metrics import Frame, Row, metric

TARGET = "target of tierod"  # Source of the claims that no paper makes


@dataclass(frozen=True)
class Dataset:
    """Drives and what methods make of them: the rows of all tasks."""

    name: str  # name of the dataset, and of its file
    title: str  # its subject, in a few words
    # importable function from a task to its rows; its docstring stands in the report
    rows: Callable[[Any], Any]
    tasks: Callable[[Effort], Sequence[Any]]  # tasks of an effort, which can be pickled
    missing: str = ""  # why there is nothing where no task gives a row, such as a recording that is not there
    # function from what all tasks made to the rows, where a row needs several tasks; `rows` then makes anything
    joined: Callable[[list[Any]], Sequence[Row]] = lambda made: [row for rows in made for row in rows]

    def frame(self, effort: Effort) -> Frame:
        """The rows of all tasks."""
        made = effort.made(self.rows, list(self.tasks(effort)), lambda task: f"a task of '{self.name}' ({task})")
        return Frame.of(self.name, self.joined(made))


@dataclass(frozen=True)
class Measure:
    """How a claim gets its figure."""

    # id, claim, source, goal, unit, printed, derived, note, cause, irreproducible: as in `tierod.core.claims.Claim`
    id: str
    claim: str
    dataset: str  # name of the dataset
    metric: str  # "metric column", or "metric column / metric column"
    goal: str = ""
    source: str = TARGET
    where: Mapping[str, Any] = field(default_factory=dict)  # rows that count, see `Frame.where`
    # changed conditions of the rows whose figure divides; empty where nothing divides
    over: Mapping[str, Any] = field(default_factory=dict)
    by: Sequence[str] = ()  # columns whose every combination of values gives a figure of its own
    across: str = "max"  # metric that joins those figures
    least: int = 1  # rows below which there is no figure
    unit: str = ""
    printed: float | str | None = None
    derived: float | None = None
    note: str = ""
    cause: str = ""
    irreproducible: bool = False

    def of(self, frame: Frame, missing: str = "") -> Claim:
        """The claim with its figure.

        Args:
            missing: why the dataset is empty, if it is
        """
        goal = Goal.read(self.goal) if self.goal else None
        # The rows that count and those that divide are chosen within each group.
        shared = {name: each for name, each in self.where.items() if name not in self.over}
        rows = frame.where(shared) if len(frame) else frame
        enough = len(rows) >= self.least
        few = missing or f"{len(rows)} of {self.least} rows: too few to judge."
        return Claim(
            self.id,
            self.claim,
            self.source,
            self.printed,
            self._figure(rows) if enough else None,
            goal,
            self.unit,
            f"{self.note} {f'{len(rows)} rows.' if enough else few}".strip(),
            self.derived,
            self.cause,
            self.irreproducible,
        )

    def _figure(self, rows: Frame) -> float:
        figures = [self._ratio(group) for _, group in rows.groups(*self.by)]
        return metric(f"{self.across} figure", Frame.of(rows.name, [{"figure": each} for each in figures]))

    def _ratio(self, rows: Frame) -> float:
        if not self.over:
            return metric(self.metric, rows)
        counted, divides = (rows.where({**self.where, **more}) for more in ({}, self.over))
        if not (len(counted) and len(divides)):
            raise ParameterError(f"no row of '{rows.name}' is {self.where if len(divides) else self.over}")
        return metric(self.metric, counted) / metric(self.metric, divides)


@dataclass(frozen=True)
class Overview:
    """A table of a dataset: a row for every combination of values of some columns."""

    dataset: str  # name of the dataset
    title: str  # meaning of the figures, with the unit
    by: Sequence[str]  # columns whose values name a row
    columns: Mapping[str, str]  # metric by heading
    where: Mapping[str, Any] = field(default_factory=dict)  # rows that count
    note: str = ""  # hint for reading it

    def of(self, frame: Frame) -> Table:
        """The table."""
        from tierod.report.display import number

        rows = tuple(
            (", ".join(f"{each}" for each in key), *(number(metric(text, group), 3) for text in self.columns.values()))
            for key, group in frame.where(self.where).groups(*self.by)
        )
        return Table(self.title, (", ".join(self.by).replace("_", " "), *self.columns), rows, self.note)


@dataclass(frozen=True)
class Claims:
    """The file of a study: its claims and tables."""

    document: Document  # as read
    measures: tuple[Measure, ...]  # its rows `[[claim]]`
    overviews: tuple[Overview, ...]  # its rows `[[table]]`

    @classmethod
    def read(cls, path: Path) -> Claims:
        """Read a file of claims.

        Raises:
            ParameterError: an unknown or missing key, a goal that is no range, or a name given twice, with its line
        """
        document = Document.read(path)
        measures = tuple(_built(Measure, document, "claim"))
        for place, each in enumerate(measures):
            with _Located(document, ("claim", place, "goal")):
                _ = Goal.read(each.goal) if each.goal else None
            if each.id in {other.id for other in measures[:place]}:
                raise document.error(("claim", place, "id"), f"the claim '{each.id}' stands twice")
        return cls(document, measures, tuple(_built(Overview, document, "table")))

    def items(self, dataset: Dataset, frame: Frame) -> Iterator[Item]:
        """Heading, tables and claims of a dataset."""
        paragraphs = (inspect.getdoc(dataset.rows) or "").split("\n\n")
        yield Heading(dataset.title, tuple(each.replace("\n", " ") for each in paragraphs if each))
        for place, table in enumerate(self.overviews):
            if table.dataset == dataset.name and len(frame):
                with _Located(self.document, ("table", place)):
                    yield table.of(frame)
        for place, each in enumerate(self.measures):
            if each.dataset == dataset.name:
                with _Located(self.document, ("claim", place)):
                    yield each.of(frame, dataset.missing)


class _Located:
    """Context that adds file, line and row to the message of an error."""

    def __init__(self, document: Document, location: Location):
        self.document, self.location = document, location

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ParameterError):
            name, place = self.location[:2]
            table = self.document.content[name][place]  # type: ignore[index]
            row = table.get("id", table.get("title"))
            raise self.document.error(self.location, f"'{row}': {error}") from None


def _built(kind: Any, document: Document, name: str) -> Iterator[Any]:
    known = {each.name: each for each in fields(kind)}
    for place, table in enumerate(document.content.get(name, [])):
        for key in table:
            if key not in known:
                raise document.error((name, place, key), f"a {name} has no key '{key}'{nearest(key, known)}")
        for key, each in known.items():
            if key not in table and each.default is MISSING and each.default_factory is MISSING:
                raise document.error((name, place), f"the {name} '{table.get('id', place + 1)}' lacks '{key}'")
        yield kind(**table)


def items(
    path: Path,
    datasets: Sequence[Dataset],
    effort: Effort,
    progress: Progress,
    charts: Callable[[Mapping[str, Frame], Effort], Iterator[Chart]] | None = None,
) -> Iterator[Item | Frame]:
    """Everything that a study shows: every dataset with its tables and claims, then the charts.

    Args:
        progress: called with the completed share and the subject of the next dataset

    Raises:
        ParameterError: a wrong file of claims, or a claim on a dataset or column that does not exist
    """
    claims, frames = Claims.read(path), dict[str, Frame]()
    known = [each.name for each in datasets]
    for name, named in (
        ("claim", [each.dataset for each in claims.measures]),
        ("table", [each.dataset for each in claims.overviews]),
    ):
        for place, dataset_name in enumerate(named):
            if dataset_name not in known:
                message = f"there is no dataset '{dataset_name}'{nearest(dataset_name, known)}"
                raise claims.document.error((name, place, "dataset"), message)
    for done, dataset in enumerate(datasets):
        progress(done / len(datasets), dataset.title)
        frame = frames[dataset.name] = dataset.frame(effort)
        yield frame
        yield from claims.items(dataset, frame)
    if charts is not None:
        yield from charts(frames, effort)
    progress(1.0, "done")
