"""Channels of a plan, made from the loaded columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.core.timestamps import finite_or_missing
from tierod.io.readers.mapping import Pick, Plan

# Speed [m/s] that hardly any road vehicle reaches (216 km/h), but the numbers of any motorway drive in km/h do
FASTEST = 60.0


def made_from(plan: Plan, loaded: Sequence[Channel], doubts: Doubts) -> list[Channel]:
    """The channels of a plan from the columns loaded; a channel of which a column is missing is not made."""
    by_name = {channel.name: channel for channel in loaded}
    channels = []
    for pick in plan.picks:
        parts = [by_name[column] for column in pick.columns if column in by_name]
        if len(parts) < len(pick.columns):
            continue
        channel = doubts.measured(_made(pick, parts))
        channels.append(channel)
        if pick.assumed:
            doubts.see(channel)
    return channels


# Multiple of the plausible range of a signal from which a number is no measurement, whatever the fault of its sensor
# and its unit: a code for a missing value, such as 3.4e38, or damage. Its powers would exceed the range of a float.
BEYOND: Annotated[float, ""] = 1e6


class Doubts:
    """What is doubtful in the values so far: magnitudes of signals without a unit, numbers that are no measurement."""

    def __init__(self) -> None:
        self._most: dict[str, float] = {}
        self._beyond: dict[str, int] = {}

    def measured(self, channel: Channel) -> Channel:
        """The next stretch of a channel, with numbers beyond any physical range missing, counted in its note."""
        known = SIGNALS.get(channel.name)
        if known is not None and channel.unit == known.unit:
            far = np.abs(channel.values) > BEYOND * max(map(abs, known.plausible))
            if count := int(np.count_nonzero(far)):
                self._beyond[channel.name] = self._beyond.get(channel.name, 0) + count
                channel = replace(channel, values=np.where(far, np.nan, channel.values))
        count = self._beyond.get(channel.name, 0)
        return channel.noted(f"{count} values beyond any physical range taken as missing" if count else "")

    def see(self, channel: Channel) -> None:
        """Record the magnitude of a channel over the next stretch of the recording."""
        finite = channel.values[np.isfinite(channel.values)]
        if len(finite):
            self._most[channel.name] = max(self._most.get(channel.name, 0.0), float(np.abs(finite).max()))

    def sentences(self, plan: Plan) -> tuple[str, ...]:
        """Remarks on the signals of a plan whose unit was assumed."""
        seen = (pick for pick in plan.picks if pick.assumed and pick.name in self._most)
        return tuple(filter(None, (_doubt(pick, self._most[pick.name]) for pick in seen)))


def _made(pick: Pick, parts: list[Channel]) -> Channel:
    values = parts[0].values
    for part in parts[1:]:
        if len(part.time) != len(parts[0].time) or not np.array_equal(part.time, parts[0].time):
            raise InputError(
                f"'{pick.name}': the sources {', '.join(pick.columns)} have different time stamps and cannot be summed"
            )
        with np.errstate(over="ignore"):
            values = values + part.values
    values = np.asarray(values, dtype=float)
    gain = pick.entry.sign * pick.entry.factor
    with np.errstate(over="ignore"):  # what exceeds the range of a float is missing, and noted
        if gain != 1.0:
            values = gain * values
        if pick.entry.offset:
            values = values + pick.entry.offset
        values, infinite = finite_or_missing(pick.scale(values))
    source = " + ".join(part.source or part.name for part in parts)
    channel = Channel(pick.name, parts[0].time, values, pick.unit, source, parts[0].note)
    return channel.noted(*pick.notes, "values that are too large taken as missing" if infinite else "")


def _doubt(pick: Pick, most: float) -> str:
    """Remark on a signal without a unit whose values, up to a magnitude, do not look like its SI unit."""
    known = SIGNALS[pick.name]
    low, high = known.plausible
    angular, speed = known.unit.startswith("rad"), known.unit == "m/s"
    place = f"{pick.name} ('{pick.columns[0]}') has no unit in the file and was taken as {known.unit}"
    if speed and most > FASTEST:
        return f'{place}, but reaches {most:.4g} m/s: if it is km/h, give unit = "km/h" in a channel map'
    if most > max(abs(low), abs(high)):
        guess = known.unit.replace("rad", "deg")
        in_degrees = angular and math.radians(most) <= max(abs(low), abs(high))
        looks = f'looks like {guess}: give unit = "{guess}"' if in_degrees else "is not plausible: give its unit"
        return f"{place}, but reaches {most:.4g} and {looks} in a channel map"
    return f"{place}: confirm it in a channel map" if angular or speed else ""


def measured(recording: Recording) -> Recording:
    """A recording made by a program, with numbers beyond any physical range missing, as in one that is read."""
    doubts = Doubts()
    return replace(recording, channels={name: doubts.measured(each) for name, each in recording.channels.items()})


def shifted(channels: Sequence[Channel], origin: float) -> list[Channel]:
    """The channels with their time counted from `origin` [s]; stamps that are shared stay shared."""
    moved: dict[int, np.ndarray] = {}
    for channel in channels:
        if id(channel.time) not in moved:
            moved[id(channel.time)] = np.asarray(channel.time, dtype=float) - origin
    return [replace(channel, time=moved[id(channel.time)]) for channel in channels]
