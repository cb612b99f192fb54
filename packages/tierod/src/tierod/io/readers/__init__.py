"""Reading of recordings: one function for every format, chosen by the content of the file.

recording = read("drive.mf4")
recording = read("can.log", dbc="car.dbc", channel_map="car.channels.toml")
"""

from __future__ import annotations

from tierod.io.readers.channel_map import ChannelMap, TimeEntry, load_channel_map, parse_channel_map
from tierod.io.readers.content import Content
from tierod.io.readers.frames import Frames
from tierod.io.readers.opening import READERS, open_source
from tierod.io.readers.reading import LACKING, SHARE_READ, open_chunks, read
from tierod.io.readers.source import Column, Format, Piece, Source, begins_with, source_of

__all__ = [
    "LACKING",
    "READERS",
    "SHARE_READ",
    "ChannelMap",
    "Column",
    "Content",
    "Format",
    "Frames",
    "Piece",
    "Source",
    "TimeEntry",
    "begins_with",
    "load_channel_map",
    "open_chunks",
    "open_source",
    "parse_channel_map",
    "read",
    "source_of",
]
