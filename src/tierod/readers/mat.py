"""MATLAB 5 files through SciPy: vectors and structures of vectors beside a time vector."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.errors import InputError
from tierod.readers.channel_map import GUESSED, TimeEntry
from tierod.readers.clocks import is_time, require_plausible_rate, unit_of
from tierod.readers.clocks import seconds as to_seconds
from tierod.readers.source import Column, Source
from tierod.recording import Channel

_PERIODS = ("Ts", "ts", "dt", "Dt", "SampleTime", "sample_time")


def open_mat(path: Path, given: TimeEntry = GUESSED) -> Source:
    """A MATLAB file of version 5 to 7.2.

    Args:
        path: of the file
        given: which vector is the time, as a user says

    Raises:
        InputError: the file is damaged, of version 7.3, or holds no vectors beside a time vector
    """
    import scipy.io

    try:
        content = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        raise InputError(f"{path} is a MATLAB 7.3 file; save it with -v7") from None
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(
            f"{path} is damaged or cut off and cannot be read as MATLAB file ({reason}); save it again"
        ) from None
    channels: dict[str, Channel] = {}
    clocks: list[tuple[str, str, np.ndarray]] = []
    for prefix, members in _structures(
        "", {name: value for name, value in content.items() if not name.startswith("__")}
    ):
        for channel in _timed(prefix, members, given, clocks):
            channels.setdefault(channel.name, channel)
    try:
        if given.column and given.column not in [name for name, *_ in clocks]:
            raise InputError(f"the channel map names the time '{given.column}', and no vector is called so")
        require_plausible_rate(clocks)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if not channels:
        raise InputError(f"{path} holds no vectors beside a time vector; save a vector 't' in seconds with the signals")
    several = len({name.rpartition(".")[0] for name in channels}) > 1
    columns = tuple(
        Column(name, channel.unit, name.rpartition(".")[2], several and "." in name)
        for name, channel in channels.items()
    )

    def load(names: Sequence[str]) -> list[Channel]:
        return [channels[name] for name in names]

    return Source(columns, load, {"format": "MATLAB 5"})


def _structures(prefix: str, members: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """(name, members) of the file itself and of every structure in it."""
    yield prefix, members
    for name, value in members.items():
        full = f"{prefix}.{name}" if prefix else name
        if hasattr(value, "_fieldnames"):
            yield from _structures(full, {field: getattr(value, field) for field in value._fieldnames})
        elif isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1:
            for number, entry in enumerate(value):
                if hasattr(entry, "_fieldnames"):
                    yield from _structures(
                        f"{full}{number}", {field: getattr(entry, field) for field in entry._fieldnames}
                    )


def _timed(
    prefix: str, members: dict[str, Any], given: TimeEntry, clocks: list[tuple[str, str, np.ndarray]]
) -> Iterator[Channel]:
    """The vectors of one structure that have as many samples as its time, or as its sampling period allows.

    Its clock is added to `clocks`: name, unit as far as it is told, stamps as recorded.
    """
    vectors = {name: value for name, value in members.items() if _is_vector(value)}
    clock, note = next((name for name in vectors if name == given.column), None), ""
    clock = clock or next((name for name in vectors if is_time(name)), None)
    if clock is not None:
        stamps, unit = np.asarray(vectors.pop(clock), dtype=float), unit_of(Column(clock), given)
        clocks.append((clock, unit, stamps))
        time, note = to_seconds(stamps, unit, clock)
    else:
        period = next((members[name] for name in _PERIODS if np.ndim(members.get(name, [0])) == 0), None)
        if not isinstance(period, int | float | np.number) or not vectors:
            return
        time = float(period) * np.arange(max(len(value) for value in vectors.values()))
    for name, value in vectors.items():
        if len(value) == len(time):
            full = f"{prefix}.{name}" if prefix else name
            yield Channel(full, time, np.asarray(value, dtype=float), "", full, note)


def _is_vector(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 1
