"""Benches whose parameters are not those of their file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tierod.proving_ground.cars.column_bench import ColumnBench

SCATTERED = (
    "wheel_inertia",
    "wheel_damping",
    "bar_stiffness",
    "gear_stiffness",
    "gear_inertia",
    "motor_inertia",
    "motor_damping",
)
"""Parameters of the bench that scatter; for control its friction does besides, for hands the gain of the sensor."""

FRESH = 1000
"""First seed of the columns that are reported; the control was chosen on those before."""


def scattered(deviation: float, seed: int) -> ColumnBench:
    """A bench whose parameters are off by some standard deviation, each by itself.

    Args:
        deviation: relative
        seed: of the draw
    """
    bench = ColumnBench()
    factors = 1.0 + deviation * np.random.default_rng([seed, 53]).normal(size=len(SCATTERED) + 1)
    changes: dict[str, Any] = {
        name: float(getattr(bench, name) * factor) for name, factor in zip(SCATTERED, factors, strict=False)
    }
    return replace(bench, friction=replace(bench.friction, level=float(bench.friction.level * factors[-1])), **changes)
