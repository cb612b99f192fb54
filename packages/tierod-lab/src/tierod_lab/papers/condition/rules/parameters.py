"""Parameters and coefficients of the residuals, their catalogue, and their calibration in a vehicle file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from tierod.core.errors import ParameterError
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.vehicles import Vehicle

CarParameters: TypeAlias = AutomatedVehicle.Parameters
"""Parameters of the vehicle, named as in its file.

Source: Li, Frey, Gauterin, Table A1. There `i` is the inverse of the rack ratio, although eqs (1) to (3) need the ratio
itself and eq (5) inverts it; the inertia is printed in a thousandth of its unit.
"""


def part(kind: Any, car: CarParameters) -> Any:
    """Parameters of a model from those of the vehicle with the same names."""
    return kind(**{each.name: getattr(car, each.name) for each in fields(kind) if hasattr(car, each.name)})


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of the models of torque, tie-rod force, angle and drives, by least squares on fault-free drives."""

    # angle, rate, acceleration: torque over angle, rate and acceleration of the steering, a1 to a3 of eq (11)
    angle: Annotated[float, "N*m/rad"] = 0.0
    rate: Annotated[float, "N*m*s/rad"] = 0.0
    acceleration: Annotated[float, "kg*m**2"] = 0.0
    friction: Annotated[float, "N*m"] = 0.0  # dry friction, with the sign of the rate
    # torque over lateral acceleration; missing in eq (11), which holds without a tie-rod force only
    cornering: Annotated[float, "kg*m"] = 0.0
    torque_offset: Annotated[float, "N*m"] = 0.0  # offset of the torque sensor
    per_mass: Annotated[float, ""] = 0.0  # per_mass, per_torque: a4 and a5 of eq (46)
    per_torque: Annotated[float, "1/m"] = 0.0
    force_friction: Annotated[float, "N*m"] = 0.0  # dry friction of eq (46), with the sign of the rate
    force_offset: Annotated[float, "N"] = 0.0  # offset of the force sensor
    # steer angle over speed times yaw rate, which eq (7) leaves out
    understeer: Annotated[float, "rad*s**2/m"] = 0.0
    angle_offset: Annotated[float, "rad"] = 0.0  # offset of the angle sensor
    # inertia, resistance, drag, turning: force of the drives over longitudinal acceleration, constant, over squared
    # speed, and over lateral acceleration times steer angle
    inertia: Annotated[float, "kg"] = 0.0
    resistance: Annotated[float, "N"] = 0.0
    drag: Annotated[float, "N*s**2/m**2"] = 0.0
    turning: Annotated[float, "kg"] = 0.0


@dataclass(frozen=True)
class Residual:
    """One residual: estimate less measurement, or target less actual value."""

    name: str  # name in the rules
    meaning: str  # short description
    equation: str  # equation of the paper
    signals: tuple[str, ...]  # canonical signals that determine its value, without wheel speeds that only enable it
    unit: str  # SI unit
    correction: str = ""  # correction of the printed equation, "" for none
    moving: bool = True  # whether it is enabled only while the vehicle moves
    steady: bool = False  # whether it is enabled only while the commanded steering torque does not jump
    gentle: bool = False  # whether it is enabled only at lateral accelerations at which the tyres are linear


_CATALOGUE = Document.read(Path(__file__).with_name("residuals.toml"))
RESIDUALS: dict[str, Residual] = {
    each["name"]: build(Residual, each, _CATALOGUE, ("residual", place))
    for place, each in enumerate(_CATALOGUE.content["residual"])
}
"""Residuals r1 to r19 of the sensors; r1a to r8a of the actuators, r1 to r8 in the paper; four beyond the paper."""


@dataclass(frozen=True)
class ResidualCalibration:
    """Calibration of the residuals of a vehicle."""

    coefficients: Coefficients  # coefficients of the models
    thresholds: Mapping[str, float]  # threshold by residual; infinite for one that was never present
    samples: int  # number of fault-free samples behind the thresholds
    printed: bool = False  # whether the equations keep their misprints


UNCALIBRATED = 1.5
"""Factor on thresholds that were calibrated on another vehicle than the judged one [-].

Source: three virtual demonstrators with mass, stiffness, radius and friction off by 4 to 20 %, two fault-free hours on
new rounds: 491 false alarms at a factor of 1, none at 1.5 and 2; mean accuracy of 144 tests 0.967, 0.944, 0.882.
"""


def name_of(printed: bool) -> str:
    """Name of the table of thresholds in a vehicle file."""
    return "residuals-printed" if printed else "residuals"


def table_of(calibration: ResidualCalibration, source: str) -> dict[str, float | str | Mapping[str, float]]:
    """A calibration as a vehicle file holds it."""
    return {
        "source": source,
        "samples": float(calibration.samples),
        "coefficients": asdict(calibration.coefficients),
        "base": {name: each for name, each in calibration.thresholds.items() if math.isfinite(each)},
    }


@lru_cache(maxsize=2)
def shipped_calibration(printed: bool = False) -> ResidualCalibration:
    """The calibration of the nominal demonstrator, with wider thresholds, since no vehicle is the nominal one."""
    table = Document.read(Path(__file__).with_name("smartload.toml")).content[name_of(printed)]
    return _calibration(table, printed, UNCALIBRATED)


def calibration_of(vehicle: Vehicle, printed: bool = False) -> ResidualCalibration:
    """The calibration of a vehicle file; the shipped one where the file has none.

    Raises:
        ParameterError: the table has an unknown or missing entry, or a value that no calibration writes
    """
    table = vehicle.thresholds.get(name_of(printed))
    if table is None:
        return shipped_calibration(printed)
    strange = _strange(table)
    if strange:
        raise ParameterError(
            f"[thresholds.{name_of(printed)}] of the vehicle '{vehicle.name}' does not fit at '{strange[0]}'; "
            "calibrate it anew with 'tierod identify thresholds'"
        )
    return _calibration(table, printed)


def _calibration(table: Mapping[str, Any], printed: bool, widened: float = 1.0) -> ResidualCalibration:
    thresholds = {name: widened * float(table["base"].get(name, math.inf)) for name in RESIDUALS}
    return ResidualCalibration(Coefficients(**table["coefficients"]), thresholds, int(table["samples"]), printed)


def _strange(table: Mapping[str, Any]) -> list[str]:
    """Names of entries that are unknown or missing, or whose values no calibration writes."""
    # Files of earlier versions hold the deviations of the residuals as well.
    strange = [name for name in table if name not in ("source", "samples", "coefficients", "base", "deviation")]
    strange += [name for name in ("base", "coefficients") if not isinstance(table.get(name), Mapping)]
    if not isinstance(table.get("samples"), float):
        strange.append("samples")
    if strange:
        return strange
    strange += sorted(set(table["coefficients"]) ^ {each.name for each in fields(Coefficients)})
    return strange + [name for name, value in table["base"].items() if name not in RESIDUALS or not value > 0.0]
