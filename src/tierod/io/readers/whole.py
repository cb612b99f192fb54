"""Reading a recording whole."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path

from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.opening import Paths, open_source
from tierod.io.readers.streaming import SHARE_READ, Reading, loaded_map, planned


def read(
    path: str | Path,
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    names: Iterable[str] | None = None,
) -> Recording:
    """The recording in a file, with canonical names and in SI units.

    Args:
        path: MF4, MDF, Parquet, CSV, MATLAB 5, candump -L, ASC, BLF or TRC; text may be packed with gzip
        dbc: database of a CAN log, or several; a bare name such as "rav4" means the one that tierod ships
        channel_map: TOML file that says which column is which signal; a bare name means the one that tierod ships;
            where not given, "car.channels.toml" beside "car.dbc" is used if it is there (metadata "channel_map")
        names: the signals (or columns) wanted, all where not given; signals that the file lacks are derived where
            tierod.io.derive has a recipe, and are absent otherwise

    Returns:
        time counts from the first stamp where the file has calendar time (metadata "origin" keeps it);
        what was guessed, repaired or lost stands in `warnings` and in the notes of the channels

    Raises:
        InputError: the file, the database or the map cannot be used; the message says what to do
        MissingExtra: the library for this format is not installed
    """
    names = None if names is None else tuple(names)
    used = loaded_map(channel_map)
    source, kind = open_source(path, dbc, used.time if used else None)
    (whole,) = Reading(path, source, kind, planned(path, source, used, names)).slices(math.inf)
    metadata = {key: value for key, value in whole.metadata.items() if key != SHARE_READ}
    whole = dataclasses.replace(whole, metadata=metadata)
    return whole if names is None else complete(whole, names)
