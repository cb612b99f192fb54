"""Shipped vehicle that the metadata of a recording name."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Recording
from tierod.vehicles import shipped

KEYS = ("vehicle_file", "virtual_car", "vehicle")
"""Entries of a recording's metadata that may name a vehicle; many virtual cars have the name of their vehicle file."""

SHORT = 1.0  # Duration of a recording that is read to obtain its metadata [s]


def vehicle_named_in(source: Recording | str | Path, dbc: Any = None, channel_map: Any = None) -> str:
    """Name of the shipped vehicle that the metadata of a recording name."""
    metadata = source.metadata if isinstance(source, Recording) else _metadata(source, dbc, channel_map)
    named = [metadata[key] for key in KEYS if isinstance(metadata.get(key), str)]
    for name in named:
        if name in shipped():
            return str(name)
    shown = f"names '{named[0]}', which tierod does not ship" if named else "names none"
    raise ParameterError(
        f"no vehicle is given, and the recording {shown}; give --vehicle (in Python: vehicle=...) with a name of "
        "'tierod vehicles' or the path of a TOML file"
    )


def other_vehicle(metadata: Mapping[str, Any], judged_as: str) -> str | None:
    """Warning if a recording names another shipped vehicle than the one whose parameters are used; None if not."""
    named = made_with(metadata, judged_as)
    if named is None:
        return None
    return (
        f"the recording was made with the vehicle '{named}', but is judged as '{judged_as}': where these differ, the "
        "verdict is not valid; check --vehicle"
    )


def made_with(metadata: Mapping[str, Any], judged_as: str) -> str | None:
    """Name of another shipped vehicle that the recording names; None if there is none. Arguments: `other_vehicle`."""
    named = [metadata[key] for key in KEYS if isinstance(metadata.get(key), str)]
    return None if judged_as in named else next((name for name in named if name in shipped()), None)


def _metadata(path: str | Path, dbc: Any, channel_map: Any) -> Mapping[str, Any]:
    from tierod.io.readers import open_chunks

    if os.path.exists(path) and Path(path).is_fifo():
        raise InputError(
            f"no vehicle is given, and {path} is a pipe, which can be read once only; give --vehicle (in Python: "
            "vehicle=...)"
        )
    try:
        return next(iter(open_chunks(path, seconds=SHORT, dbc=dbc, channel_map=channel_map))).metadata
    except InputError as error:
        if not Path(path).is_file():
            raise
        raise InputError(
            f"no vehicle is given, and none can be read from the recording: {error}; or give --vehicle (in Python: "
            "vehicle=...), whose file may name databases and channel map"
        ) from None
