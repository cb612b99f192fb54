"""Calibrations of the residuals in a vehicle file, beside the limits of the bank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

from tierod.core.errors import ParameterError
from tierod.monitors.condition.residuals.calibration import ResidualCalibration
from tierod.monitors.condition.residuals.catalogue import RESIDUALS
from tierod.monitors.condition.residuals.parameters import Coefficients
from tierod.monitors.condition.residuals.storage import shipped_calibration
from tierod.monitors.condition.residuals.thresholds import ResidualThreshold
from tierod.vehicles import Vehicle

PARTS = tuple(each.name for each in fields(ResidualThreshold))
"""Numbers of a threshold."""


def name_of(printed: bool) -> str:
    """Of the thresholds in a vehicle file.

    Args:
        printed: whether the equations keep their misprints
    """
    return "residuals-printed" if printed else "residuals"


def table_of(calibration: ResidualCalibration, source: str) -> dict[str, float | str | Mapping[str, float]]:
    """A calibration as a vehicle file holds it.

    Args:
        calibration: of the residuals
        source: of the drives
    """
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
    """The calibration that a vehicle file holds; where it holds none, the shipped one, widened.

    Args:
        vehicle: whose file it is
        printed: whether the equations keep their misprints

    Raises:
        ParameterError: a calibration with a residual or a coefficient too few or too many
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
    """Refuse a table that no calibration has written."""
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
    """A residual that was never there on healthy drives is never judged."""
    return math.inf if part == "base" else 0.0
