"""Reading recordings: one function for every format, chosen by the content of the file.

recording = read("drive.mf4")
recording = read("can.log", dbc="car.dbc", channel_map="car.channels.toml")
"""

from __future__ import annotations

from tierod.readers.channel_map import ChannelMap, load_channel_map, parse_channel_map
from tierod.readers.frames import Frames
from tierod.readers.opening import open_source
from tierod.readers.source import Column, Source
from tierod.readers.streaming import SHARE_READ, open_chunks
from tierod.readers.whole import read

__all__ = [
    "SHARE_READ",
    "ChannelMap",
    "Column",
    "Frames",
    "Source",
    "load_channel_map",
    "open_chunks",
    "open_source",
    "parse_channel_map",
    "read",
]
