"""CAN databases and channel map that describe the frames on a vehicle's buses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tierod.core.errors import ParameterError
from tierod.io.readers.channel_map import ChannelMap, load_maps_beside, maps_beside
from tierod.io.readers.dbc import load_databases
from tierod.io.readers.opening import Paths, shipped
from tierod.io.readers.streaming import loaded_map
from tierod.vehicles import Vehicle
from tierod.vehicles.reading import Map, read_by

if TYPE_CHECKING:
    from cantools.database.can import Message


class BusFiles(NamedTuple):
    """CAN databases and channel map by which frames are decoded.

    `map_named` is the map as given or as the vehicle file names it; None where maps beside the databases are used.
    """

    paths: list[Path]
    database: list[Message]
    channel_map: ChannelMap | None
    map_named: Map


def bus_files(car: Vehicle, dbc: Paths = None, channel_map: Map = None) -> BusFiles:
    """The files that are given, else those of the vehicle; without a map, the maps beside the databases.

    Args:
        car: the vehicle with these buses
        dbc: path(s) of databases
        channel_map: path of a map, or a map

    Raises:
        ParameterError: no database is given, and the vehicle names none
        InputError: a file cannot be read
    """
    databases, named = read_by(car, dbc, channel_map)
    if not databases:
        raise ParameterError(f"the vehicle '{car.name}' names no CAN database; give one with --dbc")
    paths = [shipped(each, ".dbc") for each in databases]
    beside = () if named else maps_beside(paths)
    return BusFiles(
        paths, load_databases(paths), load_maps_beside(beside) if beside else loaded_map(named), named or None
    )
