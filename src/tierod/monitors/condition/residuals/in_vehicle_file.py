"""Calibrations of the residuals in a vehicle file, beside the limits of the bank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, fields

from tierod.errors import ParameterError
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
    given = {part: dict(table.get(part, {})) for part in (*PARTS, "coefficients", "deviation")}
    coefficients = {each.name for each in fields(Coefficients)}
    strange = [name for part in (*PARTS, "deviation") for name in given[part] if name not in RESIDUALS]
    strange += sorted(set(given["coefficients"]) ^ coefficients)
    if strange:
        raise ParameterError(
            f"[thresholds.{name_of(printed)}] of the vehicle '{vehicle.name}' does not fit at '{strange[0]}'; "
            "calibrate it anew with 'tierod identify thresholds'"
        )
    thresholds = {
        name: ResidualThreshold(**{part: float(given[part].get(name, _missing(part))) for part in PARTS})
        for name in RESIDUALS
    }
    deviations = {name: float(given["deviation"].get(name, math.nan)) for name in RESIDUALS}
    samples = int(table.get("samples", 0))
    return ResidualCalibration(Coefficients(**given["coefficients"]), thresholds, deviations, samples, printed)


def _missing(part: str) -> float:
    """A residual that was never there on healthy drives is never judged."""
    return math.inf if part == "base" else 0.0
