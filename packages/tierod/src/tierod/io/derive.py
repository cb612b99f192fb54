"""Signals derived from other signals, each by one stated causal method that is noted on the channel."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.physics.motor import PhaseValues, clarke


@dataclass(frozen=True)
class Recipe:
    name: str  # name of the signal
    needs: tuple[str, ...]  # signals that it is derived from
    memory: float  # length of the past that it uses [s]
    # function of the channels needed, in order, then of the further ones, None where there is none
    make: Callable[..., Channel]
    further: tuple[str, ...] = ()  # signals that are used as well where a recording has them


def _along(axis: str, a: Channel, b: Channel, c: Channel | None) -> Channel:
    """Clarke's transform; without the third phase, the sum of all three is taken as zero."""
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
    """Nearest values of a channel at the instants of another one; NaN where none is within half a sampling interval."""
    if not len(other.time):
        return np.full(len(first.time), np.nan)
    half = 0.5 * float(np.median(np.diff(first.time))) if len(first.time) > 1 else 0.0
    after = np.minimum(np.searchsorted(other.time, first.time), len(other.time) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(other.time[before] - first.time) < np.abs(other.time[after] - first.time)
    at = np.where(nearer, before, after)
    return np.where(np.abs(other.time[at] - first.time) <= half + 1e-9, other.values[at], np.nan)


def of_phases(quantity: str, axis: str) -> Recipe:
    """Recipe of a component in the axes of the stator from the phases of a quantity.

    Source: Reinelt et al., eqs (5) to (7).
    """
    a, b, c = (f"{quantity}_{phase}" for phase in "abc")
    return Recipe(f"{quantity}_{axis}", (a, b), 0.0, partial(_along, axis), (c,))


# Span of the backward difference [s]: a wheel at 0.05 rad/s then turns by more than a resolution of 0.1 degree
WINDOW = 0.05

OLDEST = 0.1  # Largest age of a wheel speed [s]; chassis buses send it every 10 to 20 ms


def backward_rate(angle: Channel) -> tuple[np.ndarray, np.ndarray]:
    """(time, rate) of an angle by the backward difference over WINDOW, which delays the rate by half of it.

    The difference is over at least one sample, and never across a gap of more than ten windows.

    Args:
        angle: [rad]
    """
    keep = np.isfinite(angle.values)
    time, values = angle.time[keep], angle.values[keep]
    if not len(time):
        return angle.time, np.full(len(angle.time), np.nan)
    now = np.arange(len(time))
    # Rounding must not exclude a sample that is exactly one window old.
    before = np.searchsorted(time, time - WINDOW * (1.0 + 1e-9), side="left")
    before = np.where(before < now, before, np.maximum(now - 1, 0))
    span = time - time[before]
    usable = (span > 0.0) & (span <= 10.0 * WINDOW)
    rate = np.divide(values - values[before], span, out=np.full(len(time), np.nan), where=usable)
    return time, rate


def _rate(angle: Channel) -> Channel:
    time, rate = backward_rate(angle)
    note = f"derived: backward difference of {angle.name} over {1e3 * WINDOW:g} ms, {0.5e3 * WINDOW:g} ms late"
    unit = "count/s" if angle.unit == "count" else f"{angle.unit}/s"
    return Channel("steering_wheel_rate", time, rate, unit, angle.source, note)


def _speed(left: Channel, right: Channel) -> Channel:
    at = np.maximum(np.searchsorted(right.time, left.time + 1e-6, side="right") - 1, 0)
    if not len(right.time):
        other = np.full(len(left.time), np.nan)
    else:
        age = left.time - right.time[at]
        other = np.where((age >= -1e-6) & (age <= OLDEST), right.values[at], np.nan)
    note = "derived: mean of the wheel speeds rear left and rear right"
    return Channel(
        "vehicle_speed", left.time, 0.5 * (left.values + other), left.unit, f"{left.source}, {right.source}", note
    )


# Recipe of every signal that can be derived from others, by name
RECIPES: dict[str, Recipe] = {
    recipe.name: recipe
    for recipe in (
        Recipe("vehicle_speed", ("wheel_speed_rear_left", "wheel_speed_rear_right"), OLDEST, _speed),
        Recipe("steering_wheel_rate", ("steering_wheel_angle",), 10.0 * WINDOW, _rate),
        *(of_phases(quantity, axis) for quantity in ("motor_current", "motor_voltage") for axis in ("alpha", "beta")),
    )
}


def ingredients(names: Iterable[str]) -> tuple[str, ...]:
    """The names, and those of the signals from which they are derived where a recording lacks them."""
    wanted = dict.fromkeys(names)
    for name in tuple(wanted):
        if name in RECIPES:
            wanted |= dict.fromkeys((*RECIPES[name].needs, *RECIPES[name].further))
    return tuple(wanted)


def complete(recording: Recording, names: Iterable[str] | None = None) -> Recording:
    """The recording with those of the named signals added that it lacks and that can be derived from its channels."""
    made = []
    for name in RECIPES if names is None else names:
        recipe = RECIPES.get(name)
        if recipe and name not in recording and all(need in recording for need in recipe.needs):
            further = (recording.channels.get(name) for name in recipe.further)
            made.append(recipe.make(*(recording[need] for need in recipe.needs), *further))
    return recording.with_channels(made) if made else recording
