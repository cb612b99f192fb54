"""Analysis of a steer-by-wire car: modes over speed, and observability of the sideslip angle, in tables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tierod.core.content import Table
from tierod.methods.analysis.neutral_steer import OUTPUTS, Shown, shown, systems, table
from tierod.models.steered_vehicle import SteeredVehicle
from tierod.physics.single_track import understeer_gradient
from tierod.report.analysis.analysis import Analysis
from tierod.vehicles import Vehicle

SPEEDS = (3.0, 6.7, 15.0, 25.0, 40.0)
"""Speeds of the modes and ranks in the tables [m/s]."""

ABOUT = (0.9, 0.99, 1.0, 1.01, 1.1)
"""Ratios of rear cornering stiffness to that of a neutral-steering car, shown beside the car's own ratio."""


def analyse(vehicle: Vehicle) -> Analysis:
    """Modes of vehicle and steering, and observability of the sideslip angle over understeer and speed.

    Args:
        vehicle: steered by wire, with the parameters of `SteeredVehicle.Parameters`

    Raises:
        ParameterError: parameters are missing
    """
    p = vehicle.parameters_for(SteeredVehicle.Parameters)
    own = p.rear_cornering_stiffness * p.rear_distance / (p.front_cornering_stiffness * p.front_distance)
    ratios = sorted({*ABOUT, round(own, 4)})
    found = shown(p, ratios, SPEEDS)
    return Analysis(
        f"Sideslip of {vehicle.name}",
        _summary(p, own, found),
        [_modes(p), table(found)],
        _document(p, own, found),
    )


def _summary(p: SteeredVehicle.Parameters, own: float, found: list[Shown]) -> tuple[str, ...]:
    gradient = math.degrees(_gradient(p))
    way = "understeers" if gradient > 0.0 else "oversteers"
    rest = [each.by_outputs[1].complete and each.by_outputs[2].complete for each in found]
    return (
        f"The car {way} by {abs(gradient):.3f} degrees per m/s²; its rear axle is {own:.2f} times as stiff as that of "
        f"a neutral car. With the yaw rate alone the sideslip angle of a neutral car is not observable; with the "
        "aligning torque, "
        f"or with the steering in the model, it is {'' if all(rest) else 'not '}observable at every understeer and "
        "speed.",
    )


def _gradient(p: SteeredVehicle.Parameters) -> float:
    return float(
        understeer_gradient(
            p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
        )
    )


def _modes(p: SteeredVehicle.Parameters) -> Table:
    rows = []
    for speed in SPEEDS:
        _, vehicle, steered, _ = systems(p, speed)
        rows.append((f"{speed:g}", _listed(vehicle.A), _listed(steered.A)))
    return Table(
        "Eigenvalues over speed (1/s), without friction",
        ("speed (m/s)", "vehicle, steer given", "vehicle and steering, torque given"),
        tuple(rows),
    )


def _listed(matrix: np.ndarray) -> str:
    values = np.sort_complex(np.linalg.eigvals(matrix))
    upper = [value for value in values if value.imag >= 0.0]
    return ", ".join(f"{v.real:.2f}" if v.imag == 0.0 else f"{v.real:.2f} ± {v.imag:.2f}i" for v in upper)


def _document(p: SteeredVehicle.Parameters, own: float, found: list[Shown]) -> dict[str, Any]:
    return {
        "rear_over_neutral": own,
        "understeer_gradient": _gradient(p),
        "observability": [
            {
                "rear_over_neutral": each.rear_over_neutral,
                "understeer_gradient": each.understeer_gradient,
                "speed": each.speed,
                "margin_of_yaw_rate": each.margin,
                "ranks": {name: one.rank for name, one in zip(OUTPUTS, each.by_outputs, strict=True)},
            }
            for each in found
        ],
    }
