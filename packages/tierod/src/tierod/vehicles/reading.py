"""Choice of CAN databases and channel map for recordings of a vehicle."""

from __future__ import annotations

from pathlib import Path

from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.opening import Paths
from tierod.vehicles.vehicle import Vehicle

Map = str | Path | ChannelMap | None


def read_by(vehicle: Vehicle | None, dbc: Paths = None, channel_map: Map = None) -> tuple[tuple[str | Path, ...], Map]:
    databases = dbc or (vehicle.database if vehicle else None) or ()
    paths = (databases,) if isinstance(databases, str | Path) else tuple(databases)
    return paths, channel_map or (vehicle.channel_map if vehicle else None)
