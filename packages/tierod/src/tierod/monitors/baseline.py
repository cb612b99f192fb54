"""Baseline: a quantity of one individual vehicle in fault-free condition, stored between recordings."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tierod.core.errors import InputError
from tierod.core.files import holding, write_text
from tierod.core.user_files import json_document, names_schema, read_text

SCHEMA = "tierod.baseline/1"


@dataclass(frozen=True)
class Baseline:
    """Value of a quantity of one vehicle in its fault-free condition."""

    vehicle: str  # name of the parameter set that was used
    monitor: str  # name of the monitor and variant that estimated it; another one may have another bias
    value: Annotated[float, "unit of the signal"]  # value [unit]
    deviation: Annotated[float, "unit of the signal"]  # standard deviation of the value [unit]
    unit: str  # unit in the notation of pint
    seconds: Annotated[float, "s"]  # time with the enabling condition fulfilled that the value is estimated from [s]
    learnt: str = ""  # date and time of the estimation, ISO 8601
    # rate of the steering wheel at which its damping acted [rad/s], of a test whose deviation excludes the damping;
    # None for others
    rate: Annotated[float | None, "rad/s"] = None


def load_baseline(path: str | Path) -> Baseline:
    """Read a baseline from a file.

    Raises:
        InputError: the file cannot be read, or is no baseline that tierod wrote
    """
    text = read_text(path, "the baseline")
    if not names_schema(text, SCHEMA):
        raise InputError(f"{path} is no baseline; it is left as it is. Name the file of a baseline, or a new file")
    try:
        return _level(text)
    except ValueError as error:
        raise InputError(
            f"{path} is not a baseline that tierod stored ({error}); name another file, or remove it to learn anew"
        ) from None


def _level(text: str) -> Baseline:
    """Parse a baseline; a ValueError states in words why the text holds none."""
    document = json_document(text)
    if document.pop("schema", None) != SCHEMA:
        raise ValueError(f"its schema is not {SCHEMA}")
    names = {field.name for field in dataclasses.fields(Baseline)}
    if strange := sorted(names.symmetric_difference({"learnt", "rate", *document})):
        raise ValueError(f"{', '.join(strange)} is missing or not known")
    level = Baseline(**document)
    figures = (level.value, level.deviation, level.seconds, 0.0 if level.rate is None else level.rate)
    if not all(isinstance(figure, int | float) and math.isfinite(figure) for figure in figures):
        raise ValueError("value, deviation, seconds and rate must be finite numbers")
    if not (level.value > 0.0 and level.deviation >= 0.0):
        raise ValueError(f"value {level.value:g} must be above zero and deviation {level.deviation:g} not negative")
    return level


def store_baseline(level: Baseline, path: str | Path) -> Path:
    """Write a baseline to a file, whole or not at all."""
    content = {name: value for name, value in dataclasses.asdict(level).items() if value is not None}
    return write_text(path, json.dumps({"schema": SCHEMA, **content}, indent=2) + "\n")


def keep_first(level: Baseline, path: str | Path) -> str:
    """Write a baseline if its file does not exist yet.

    An existing file is never changed, so that a slow fault cannot become part of the baseline.
    """
    with holding(path) as place:
        if place.exists():
            return (
                f"{path} was written by another program in the meantime and is kept; this recording was judged without "
                "it"
            )
        store_baseline(level, place)
    return f"written to {path}; later recordings are judged against it"


def refuse_foreign(level: Baseline, vehicle: str, monitor: str, path: str | Path = "the stored level") -> None:
    """Refuse a baseline of another vehicle or another monitor."""
    for what, stored, wanted in (("vehicle", level.vehicle, vehicle), ("monitor", level.monitor, monitor)):
        if stored != wanted:
            raise InputError(
                f"{path} was learnt for the {what} '{stored}', not '{wanted}'; keep one file for each, "
                "or remove it to learn anew"
            )
