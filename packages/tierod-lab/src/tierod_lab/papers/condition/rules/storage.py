"""Storage of calibrations of the residuals: TOML files, the shipped ones, and tables of a vehicle file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from tierod.core.errors import ParameterError, nearest
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.vehicles import Vehicle
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.readings import ResidualThreshold

SHIPPED = {
    False: Path(__file__).with_name("smartload-residuals.toml"),
    True: Path(__file__).with_name("smartload-residuals-printed.toml"),
}
"""Calibration files of the nominal demonstrator on fault-free virtual drives, by whether misprints are kept."""

UNCALIBRATED = 1.5
"""Factor on thresholds that were calibrated on another vehicle than the judged one [-].

Source: three virtual demonstrators with mass, stiffness, radius and friction off by 4 to 20 %, two fault-free hours on
new rounds: 491 false alarms at a factor of 1, none at 1.5 and 2; mean accuracy of 144 tests 0.967, 0.944, 0.882.
"""


def text_of(calibration: ResidualCalibration) -> str:
    """A calibration as the text of a TOML file, for writing through `tierod.core.files`."""
    lines = [
        f"samples = {calibration.samples}",
        f"printed = {str(calibration.printed).lower()}",
        f"adaptive = {str(calibration.adaptive).lower()}",
    ]
    if calibration.hours_between_alarms is not None:
        lines.append(f"hours_between_alarms = {calibration.hours_between_alarms!r}")
    lines += [
        "",
        "[coefficients]",
        *(f"{name} = {value!r}" for name, value in asdict(calibration.coefficients).items()),
    ]
    for name, threshold in calibration.thresholds.items():
        parts = {key: value for key, value in asdict(threshold).items() if value != 0.0 or key == "base"}
        parts["deviation"] = calibration.deviations.get(name, math.nan)
        lines += ["", f"[thresholds.{name}]", *(f"{key} = {_number(value)}" for key, value in parts.items())]
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    return f"{value:.6g}" if math.isfinite(value) else str(value)


def read_calibration(path: str | Path) -> ResidualCalibration:
    """Reads the calibration of a file.

    Args:
        path: path of a TOML file in the format of `text_of`

    Raises:
        ParameterError: the file cannot be read, or contains an error; the message names the line
    """
    document = Document.read(path, "calibration")
    content = document.content
    known = {field.name for field in fields(ResidualCalibration)} - {"deviations"}
    for key in content:
        if key not in known:
            raise document.error((key,), f"'{key}' is not known here{nearest(key, known)}")
    thresholds, deviations = {}, {}
    given = content.get("thresholds", {})
    for name in given:
        if name not in RESIDUALS:
            raise document.error(("thresholds", name), f"no residual is called '{name}'{nearest(name, RESIDUALS)}")
    for name in RESIDUALS:
        if name not in given:
            raise document.error(("thresholds",), f"the threshold of '{name}' is missing; calibrate again")
        table = dict(given[name])
        deviations[name] = float(table.pop("deviation", math.nan))
        thresholds[name] = _threshold(table, document, name)
    return ResidualCalibration(
        build(Coefficients, content.get("coefficients", {}), document, ("coefficients",)),
        thresholds,
        deviations,
        int(content.get("samples", 0)),
        bool(content.get("printed", False)),
        bool(content.get("adaptive", False)),
        content.get("hours_between_alarms"),
    )


def _threshold(table: dict[str, Any], document: Document, name: str) -> ResidualThreshold:
    if table.get("base") == math.inf:
        return ResidualThreshold(math.inf)
    built: ResidualThreshold = build(ResidualThreshold, table, document, ("thresholds", name), signal="")
    return built


@lru_cache(maxsize=4)
def shipped_calibration(widened: float = UNCALIBRATED, printed: bool = False) -> ResidualCalibration:
    """The shipped calibration of the demonstrator, with wider thresholds, since no vehicle is the nominal one.

    Args:
        widened: factor on all thresholds; 1 leaves them as calibrated
    """
    return widen(read_calibration(SHIPPED[printed]), widened)


def widen(calibration: ResidualCalibration, factor: float) -> ResidualCalibration:
    """A calibration with wider thresholds."""
    wider = {name: _times(each, factor) for name, each in calibration.thresholds.items()}
    return replace(calibration, thresholds=wider)


def _times(threshold: ResidualThreshold, factor: float) -> ResidualThreshold:
    # The centre is a location, not a width.
    scaled = {name: factor * value for name, value in asdict(threshold).items() if name != "centre"}
    return ResidualThreshold(**scaled, centre=threshold.centre)


PARTS = tuple(each.name for each in fields(ResidualThreshold))  # Names of the numbers of a threshold


def name_of(printed: bool) -> str:
    """Name of the thresholds in a vehicle file."""
    return "residuals-printed" if printed else "residuals"


def table_of(calibration: ResidualCalibration, source: str) -> dict[str, float | str | Mapping[str, float]]:
    """A calibration as a vehicle file holds it."""
    known = {name: each for name, each in calibration.thresholds.items() if math.isfinite(each.base)}
    parts: dict[str, float | str | Mapping[str, float]] = {
        part: {name: getattr(each, part) for name, each in known.items() if part == "base" or getattr(each, part)}
        for part in PARTS
    }
    deviations = {name: value for name, value in calibration.deviations.items() if math.isfinite(value)}
    return {
        "source": source,
        "samples": float(calibration.samples),
        "coefficients": asdict(calibration.coefficients),
        **{part: table for part, table in parts.items() if table},
        "deviation": deviations,
    }


def calibration_of(vehicle: Vehicle, printed: bool = False) -> ResidualCalibration:
    """The calibration of a vehicle file; the shipped one with wider thresholds where the file has none.

    Raises:
        ParameterError: the table has an unknown or missing entry, or a value that no calibration writes
    """
    table = vehicle.thresholds.get(name_of(printed))
    if table is None:
        return shipped_calibration(printed=printed)
    _require_fit(table, vehicle.name, name_of(printed))
    given = {part: table.get(part, {}) for part in (*PARTS, "coefficients", "deviation")}
    thresholds = {
        name: ResidualThreshold(**{part: float(given[part].get(name, _missing(part))) for part in PARTS})
        for name in RESIDUALS
    }
    deviations = {name: float(given["deviation"].get(name, math.nan)) for name in RESIDUALS}
    samples = int(table.get("samples", 0))
    return ResidualCalibration(Coefficients(**given["coefficients"]), thresholds, deviations, samples, printed)


def _require_fit(table: Mapping[str, Any], vehicle: str, of: str) -> None:
    groups = ("coefficients", "deviation", *PARTS)
    coefficients = {each.name for each in fields(Coefficients)}
    strange = [name for name in table if name not in ("source", "samples", *groups)]
    strange += [name for name in ("base", "coefficients") if name not in table]
    strange += [name for name in groups if not isinstance(table.get(name, {}), Mapping)]
    if not strange:
        given = {part: table.get(part, {}) for part in groups}
        strange = [name for part in (*PARTS, "deviation") for name in given[part] if name not in RESIDUALS]
        strange += sorted(set(given["coefficients"]) ^ coefficients)
        strange += [name for name, value in given["base"].items() if not value > 0.0]
    if not isinstance(table.get("samples", 0.0), float):
        strange.append("samples")
    if strange:
        raise ParameterError(
            f"[thresholds.{of}] of the vehicle '{vehicle}' does not fit at '{strange[0]}'; calibrate it anew with "
            "'tierod identify thresholds'"
        )


def _missing(part: str) -> float:
    return math.inf if part == "base" else 0.0
