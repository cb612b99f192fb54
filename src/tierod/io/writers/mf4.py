"""MF4 through asammdf: one channel group per group of channels with common time stamps."""

from __future__ import annotations

import datetime
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from tierod.core.errors import MissingExtra, OutputError
from tierod.core.files import replacing
from tierod.core.recording import Channel, Recording
from tierod.io.layout import Writer, description, groups

if TYPE_CHECKING:
    from asammdf import Signal


def write_mf4(recording: Recording, path: str | Path) -> None:
    """Write a recording to an MF4 file; sources and notes become comments of channels, metadata that of the file.

    Args:
        recording: with at least one channel
        path: the file; replaced as a whole

    Raises:
        MissingExtra: asammdf is not installed
        OutputError: nothing to write, or the file cannot be written
    """
    require_asammdf()
    from asammdf import MDF, Signal

    found = groups(recording)
    with replacing(path) as temporary, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = MDF(version="4.10")
        # Without a calendar time it begins in 1970; asammdf would take the time of writing.
        origin = recording.metadata.get("origin") or 0.0
        file.header.start_time = datetime.datetime.fromtimestamp(float(origin), datetime.UTC)
        file.header.comment = header_comment(description(recording, found)["metadata"])
        try:
            for number, group in enumerate(found):
                signals = [_signal(Signal, channel, group.time) for channel in group.channels]
                file.append(signals, acq_name=f"group {number}", comment="tierod", common_timebase=True)
            # asammdf names its file .mf4 whatever ending it was given.
            saved = Path(file.save(temporary, overwrite=True))
            if saved != temporary:
                saved.replace(temporary)
        except OSError:
            raise
        except Exception as error:
            reason = " ".join(str(error).split())[:160] or type(error).__name__
            raise OutputError(f"{path} cannot be written as MF4: {reason}") from None
        finally:
            file.close()


def require_asammdf() -> None:
    """Raise MissingExtra where the library that writes MF4 is not installed."""
    try:
        import asammdf  # noqa: F401
    except ImportError:
        raise MissingExtra("asammdf", "mdf", "writing an MF4 file") from None


def header_comment(metadata: Mapping[str, object]) -> str:
    """The comment of the file in the form of MDF 4: metadata as JSON in a common property called tierod."""
    root = ElementTree.Element("HDcomment")
    ElementTree.SubElement(root, "TX")
    properties = ElementTree.SubElement(root, "common_properties")
    ElementTree.SubElement(properties, "e", name="tierod").text = json.dumps(metadata)
    return ElementTree.tostring(root, encoding="unicode")


def _signal(kind: type[Signal], channel: Channel, time: np.ndarray) -> Signal:
    return kind(
        np.ascontiguousarray(channel.values, dtype=float),
        np.ascontiguousarray(time, dtype=float),
        unit=channel.unit,
        name=channel.name,
        comment=signal_comment(channel),
    )


def signal_comment(channel: Channel) -> str:
    """The comment of a channel, from which its source and note are read again."""
    return f"tierod: {channel.source} | {channel.note}" if channel.source or channel.note else ""


WRITER = Writer("MF4", write_mf4, require_asammdf)
