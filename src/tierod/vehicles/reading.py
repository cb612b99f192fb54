"""How recordings of a vehicle are read: by the files that are given, else by those that its own file names."""

from __future__ import annotations

from pathlib import Path

from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.opening import Paths
from tierod.vehicles.vehicle import Vehicle

Map = str | Path | ChannelMap | None


def read_by(vehicle: Vehicle | None, dbc: Paths = None, channel_map: Map = None) -> tuple[Paths, Map]:
    """CAN databases and channel map that recordings are read by.

    Args:
        vehicle: whose own are taken where none are given; None where no vehicle is known
        dbc: path(s) of databases
        channel_map: path of a map, or a map
    """
    if vehicle is None:
        return dbc or None, channel_map
    return dbc or vehicle.database, channel_map or vehicle.channel_map
