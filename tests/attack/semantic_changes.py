"""What a sensor, a bus or a channel map may do to a signal: changes of a recording in memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tierod.core.recording import Channel, Recording

STUCK_FROM = 1.0 / 3.0
"""Share of the recording after which a stuck signal stands still, and one that creeps begins: before any fault of the
recordings can be judged."""

CLIPPED_AT = 0.8
"""Quantile of the magnitude at which a clipped signal ends."""


def _stuck(channel: Channel, random: np.random.Generator) -> Channel:
    at = int(STUCK_FROM * len(channel.values))
    values = channel.values.copy()
    values[at:] = values[at]
    return replace(channel, values=values)


def _times(factor: float) -> Callable[[Channel, np.random.Generator], Channel]:
    return lambda channel, random: replace(channel, values=factor * channel.values)


def _offset(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values + np.nanstd(channel.values))


def _growth(channel: Channel) -> np.ndarray:
    """Share of a change that grows evenly from `STUCK_FROM` to the end."""
    share = np.linspace(0.0, 1.0, len(channel.values))
    return np.clip((share - STUCK_FROM) / (1.0 - STUCK_FROM), 0.0, 1.0)


def _drifting(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values + 2.0 * np.nanstd(channel.values) * _growth(channel))


def _growing(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values * (1.0 + _growth(channel)))


def _late(seconds: float) -> Callable[[Channel, np.random.Generator], Channel]:
    """The same values so much later; what was before the recording is taken as its first value."""

    def change(channel: Channel, random: np.random.Generator) -> Channel:
        before = np.searchsorted(channel.time, channel.time - seconds + 1e-9, side="right") - 1
        return replace(channel, values=channel.values[np.maximum(before, 0)])

    return change


def _noisy(channel: Channel, random: np.random.Generator) -> Channel:
    noise = np.nanstd(channel.values) * random.normal(size=len(channel.values))
    return replace(channel, values=channel.values + noise)


def _clipped(channel: Channel, random: np.random.Generator) -> Channel:
    most = np.nanquantile(np.abs(channel.values), CLIPPED_AT)
    return replace(channel, values=np.clip(channel.values, -most, most))


def _missing(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=np.full(len(channel.values), np.nan))


CHANGES: dict[str, Callable[[Channel, np.random.Generator], Channel]] = {
    "stuck": _stuck,
    "sign": _times(-1.0),
    "x2": _times(2.0),
    "x0.5": _times(0.5),
    "offset": _offset,
    "drift to two deviations": _drifting,
    "gain that grows to 2": _growing,
    "late .1 s": _late(0.1),
    "late .5 s": _late(0.5),
    "noise": _noisy,
    "clip": _clipped,
    "missing": _missing,
}
"""Changes of one channel by name."""

DROPPED = "dropped"
"""The column is not there."""

SWAP = "swap with "
"""Begins the name of a change that gives a signal the samples of another one, and that one its own."""


def changes(names: tuple[str, ...], signal: str) -> tuple[str, ...]:
    """Every change of a signal; each pair of signals is swapped once.

    Args:
        names: signals of the recording
        signal: which of them
    """
    others = names[names.index(signal) + 1 :]
    return (*CHANGES, DROPPED, *(f"{SWAP}{other}" for other in others))


def changed(recording: Recording, signal: str, change: str, seed: int) -> Recording:
    """The recording with one change.

    Args:
        recording: left as it is
        signal: that is changed
        change: a name as of `changes`
        seed: of noise
    """
    if change == DROPPED:
        return replace(recording, channels={n: c for n, c in recording.channels.items() if n != signal})
    channel = recording[signal]
    if change.startswith(SWAP):
        other = recording[change.removeprefix(SWAP)]
        pair = (
            replace(channel, time=other.time, values=other.values),
            replace(other, time=channel.time, values=channel.values),
        )
        return recording.with_channels(pair)
    return recording.with_channels([CHANGES[change](channel, np.random.default_rng(seed))])


def touched(signal: str, change: str) -> tuple[str, ...]:
    """The signals that a change changes."""
    return (signal, change.removeprefix(SWAP)) if change.startswith(SWAP) else (signal,)
