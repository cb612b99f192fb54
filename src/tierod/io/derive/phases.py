"""Vectors in the stator's axes from phase currents and voltages."""

from __future__ import annotations

import numpy as np

from tierod.core.recording import Channel
from tierod.io.derive.recipe import Recipe
from tierod.physics.clarke_park import PhaseValues, clarke


def _along_alpha(a: Channel, b: Channel, c: Channel | None) -> Channel:
    return _along("alpha", a, b, c)


def _along_beta(a: Channel, b: Channel, c: Channel | None) -> Channel:
    return _along("beta", a, b, c)


def _along(axis: str, a: Channel, b: Channel, c: Channel | None) -> Channel:
    """Clarke's transform; without the third phase, as if all three added up to zero."""
    phases = [a.values, _beside(a, b)]
    phases.append(-phases[0] - phases[1] if c is None else _beside(a, c))
    values = getattr(clarke(PhaseValues(*phases)), axis)
    quantity = a.name.removesuffix("_a")
    note = f"derived: Clarke's transform of {quantity}_a, _b" + (
        " and _c" if c is not None else ", which add up with _c"
    )
    sources = ", ".join(channel.source for channel in (a, b, c) if channel is not None)
    return Channel(f"{quantity}_{axis}", a.time, values, a.unit, sources, note)


def _beside(first: Channel, other: Channel) -> np.ndarray:
    """Values of a channel at the instants of another one, NaN where it brings none within half a sample."""
    if not len(other.time):
        return np.full(len(first.time), np.nan)
    half = 0.5 * float(np.median(np.diff(first.time))) if len(first.time) > 1 else 0.0
    after = np.minimum(np.searchsorted(other.time, first.time), len(other.time) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(other.time[before] - first.time) < np.abs(other.time[after] - first.time)
    at = np.where(nearer, before, after)
    return np.where(np.abs(other.time[at] - first.time) <= half + 1e-9, other.values[at], np.nan)


def of_phases(quantity: str, axis: str) -> Recipe:
    """How a vector in the stator's axes is made of a phase quantity.

    Args:
        quantity: "motor_current" or "motor_voltage"
        axis: "alpha" or "beta"

    Source: Reinelt et al., eqs (5) to (7).
    """
    a, b, c = (f"{quantity}_{phase}" for phase in "abc")
    return Recipe(f"{quantity}_{axis}", (a, b), 0.0, {"alpha": _along_alpha, "beta": _along_beta}[axis], (c,))
