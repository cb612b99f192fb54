"""Rows of a dataset, and the figures that claims and tables take from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.claims import Goal
from tierod.core.errors import ParameterError, nearest

Row = Mapping[str, float | str | bool]  # One row of a dataset: value by name of the column


@dataclass(frozen=True, eq=False)
class Frame:
    """A dataset: columns of equal length."""

    name: str  # name of the dataset
    columns: Mapping[str, np.ndarray]  # values by name, (rows,)

    @classmethod
    def of(cls, name: str, rows: Sequence[Row]) -> Frame:
        """The dataset of some rows; a number that a row lacks is NaN, a text is empty."""
        names = list(dict.fromkeys(name for row in rows for name in row))
        texts = {name for name in names if any(isinstance(row.get(name), str) for row in rows)}
        absent = {name: "" if name in texts else np.nan for name in names}
        return cls(name, {key: np.array([row.get(key, absent[key]) for row in rows]) for key in names})

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise ParameterError(f"the dataset '{self.name}' has no column '{name}'{nearest(name, self.columns)}")
        return self.columns[name]

    def where(self, conditions: Mapping[str, Any]) -> Frame:
        """The rows that meet all conditions: a value, a list of values, or a range as a text, such as ">= 40"."""
        kept = np.ones(len(self), dtype=bool)
        for name, condition in conditions.items():
            kept &= _meets(self[name], condition)
        return Frame(self.name, {name: values[kept] for name, values in self.columns.items()})

    def groups(self, *names: str) -> Iterator[tuple[tuple[Any, ...], Frame]]:
        """(values, rows) for every combination of values of some columns, in the order of the rows."""
        keys = list(zip(*(self[name].tolist() for name in names), strict=True)) if names else [()] * len(self)
        for key in dict.fromkeys(keys):
            kept = np.array([each == key for each in keys])
            yield key, Frame(self.name, {name: values[kept] for name, values in self.columns.items()})

    def write(self, folder: Path) -> Path:
        """Write the dataset to a folder as Parquet, complete or not at all."""
        import pyarrow
        from pyarrow import parquet

        from tierod.core.files import replacing

        path = folder / f"{self.name}.parquet"
        with replacing(path) as beside:
            parquet.write_table(pyarrow.table(dict(self.columns)), beside)
        return path


def _meets(values: np.ndarray, condition: Any) -> np.ndarray:
    if isinstance(condition, list):
        return np.isin(values, condition)
    if isinstance(condition, str) and values.dtype.kind != "U":
        goal = Goal.read(condition)
        return np.asarray((values >= goal.low) & (values <= goal.high))
    return np.asarray(values == condition)


def _quantile(share: float) -> Callable[[np.ndarray], float]:
    # The next higher value stands: a fault that was not found has an infinite delay, which must not be interpolated.
    return lambda values: float(np.quantile(values, share, method="higher"))


def _most_likely_events(values: np.ndarray) -> float:
    """Upper 95 % limit of a number of events that come by chance."""
    from scipy.stats import chi2

    return float(0.5 * chi2.ppf(0.95, 2.0 * (np.sum(values) + 1.0)))


METRICS: Mapping[str, Callable[[np.ndarray], float]] = {
    "count": lambda values: float(len(values)),
    "sum": lambda values: float(np.sum(values)),
    "mean": lambda values: float(np.mean(values)),
    "bias": lambda values: float(abs(np.mean(values))),
    "median": _quantile(0.5),
    "std": lambda values: float(np.std(values)),
    "rms": lambda values: float(np.sqrt(np.mean(np.square(values)))),
    "min": lambda values: float(np.min(values)),
    "max": lambda values: float(np.max(values)),
    "p05": _quantile(0.05),
    "p95": _quantile(0.95),
    "limit": _most_likely_events,
}
"""Metrics of a column by name; "limit" is the upper 95 % limit of a number of events."""


def metric(text: str, frame: Frame) -> float:
    """Figure of a dataset.

    Args:
        text: "metric column", or "metric column / metric column"
        frame: the rows, at least one

    Raises:
        ParameterError: an unknown metric or column, or a text of another form
    """
    numerator, _, denominator = text.partition(" / ")
    name, _, column = numerator.partition(" ")
    if name not in METRICS:
        raise ParameterError(f"'{name}' is no metric{nearest(name, METRICS)}; expected one of {', '.join(METRICS)}")
    value = METRICS[name](np.asarray(frame[column], dtype=float) if column else np.ones(len(frame)))
    return value / metric(denominator, frame) if denominator else value
