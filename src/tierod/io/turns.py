"""Whether the units of speed, yaw rate and lateral acceleration fit each other, as they must in every turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.recording import Recording
from tierod.io.signs import COMPARED

NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration")

KMH = 3.6


@dataclass(frozen=True)
class TurnLimits:
    """When the units count as contradicting each other.

    Args:
        rate: of the comparison [Hz]
        smoothing: time [s] that is averaged first: shorter motion is not that of a steady turn
        acceleration: root mean square of speed times yaw rate [m/s^2] that is needed; three times an offset by bank
        seconds: of driving that is needed
        correlation: from which the two go together at all; below it a signal is wrong in another way
        deviation: factor between the two that is still explained by bank, roll and gains; half of that of km/h
    """

    rate: Annotated[float, "Hz"] = 10.0
    smoothing: Annotated[float, "s"] = 1.0
    acceleration: Annotated[float, "m/s**2"] = 0.5
    seconds: Annotated[float, "s"] = 10.0
    correlation: Annotated[float, ""] = 0.8
    deviation: Annotated[float, ""] = 1.9


def turn_warnings(recording: Recording, limits: TurnLimits | None = None) -> tuple[str, ...]:
    """What to say where lateral acceleration is not about speed times yaw rate: one of them has a wrong unit."""
    limits = limits or TurnLimits()
    if not all(name in recording and len(recording[name].time) for name in NAMES):
        return ()
    ratio = _ratio(recording, limits)
    if ratio is None or 1.0 / limits.deviation < ratio < limits.deviation:
        return ()
    guess = "at least one of them is not what it says"
    for wrong, reason in (
        (1.0 / KMH, "vehicle_speed looks like km/h taken for m/s"),
        (KMH, "vehicle_speed looks converted twice"),
    ):
        if 0.75 < ratio / wrong < 1.33:
            guess = reason
    return (
        f"lateral_acceleration is {ratio:.2g} times vehicle_speed times yaw_rate, where about 1 is right: {guess}; "
        "check their units in the channel map",
    )


def _ratio(recording: Recording, limits: TurnLimits) -> float | None:
    """Lateral acceleration over speed times yaw rate, without regard to signs; None where the drive does not tell."""
    first_hour = recording.slice(stop=recording.span[0] + COMPARED)
    aligned = first_hour.align(NAMES, limits.rate, maximum_age=2.0 / limits.rate)
    width = max(round(limits.smoothing * limits.rate), 1)
    if len(aligned.time) <= width:
        return None
    speed, yaw, acceleration = (
        np.convolve(values, np.full(width, 1.0 / width), "valid") for values in aligned.values.T
    )
    expected = speed * yaw
    good = np.isfinite(expected) & np.isfinite(acceleration)
    if np.count_nonzero(good) < limits.seconds * limits.rate:
        return None
    expected, acceleration = (values[good] - np.mean(values[good]) for values in (expected, acceleration))
    power, measured = float(expected @ expected), float(acceleration @ acceleration)
    # Whichever of the two is too small, the larger one must tell of turns.
    if max(power, measured) < limits.acceleration**2 * len(expected) or min(power, measured) <= 0.0:
        return None
    correlation = abs(float(expected @ acceleration)) / (power * measured) ** 0.5
    return (measured / power) ** 0.5 if correlation >= limits.correlation else None
