"""MF4 through asammdf: one channel group per group of channels with common time stamps."""

from __future__ import annotations

import datetime
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from tierod.core.errors import MissingExtra, OutputError
from tierod.core.files import replacing
from tierod.core.recording import Channel
from tierod.io.layout import Writer
from tierod.io.writers.spool import FromSpool, Spool


def write_mf4(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to an MF4 file; sources and notes become comments of channels, metadata that of the file.

    Args:
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold: nothing
    """
    require_asammdf()
    from asammdf import MDF, Signal

    found = spool.groups()
    about = spool.description(found)
    with replacing(path) as temporary, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = MDF(version="4.10")
        # A recording without calendar time begins in 1970; asammdf would take the time of writing.
        file.header.start_time = datetime.datetime.fromtimestamp(about["origin"], datetime.UTC)
        file.header.comment = _header_comment(about["metadata"])
        try:
            for number, group in enumerate(found):
                for place, (time, values) in enumerate(group.rows()):
                    if place:
                        file.extend(number, [(time, None), *((part, None) for part in values)])
                        continue
                    signals = [
                        Signal(part, time, unit=each.unit, name=each.name, comment=_signal_comment(each))
                        for each, part in zip(group.channels, values, strict=True)
                    ]
                    file.append(signals, acq_name=f"group {number}", comment="tierod", common_timebase=True)
            # asammdf gives its file the ending .mf4, whatever it was given.
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
    return ()


def require_asammdf() -> None:
    """Raise MissingExtra where the library that writes MF4 is not installed."""
    try:
        import asammdf  # noqa: F401
    except ImportError:
        raise MissingExtra("asammdf", "mdf", "writing an MF4 file") from None


def _header_comment(metadata: Mapping[str, object]) -> str:
    """The comment of the file in the form of MDF 4, with the metadata as JSON in a common property "tierod"."""
    root = ElementTree.Element("HDcomment")
    ElementTree.SubElement(root, "TX")
    properties = ElementTree.SubElement(root, "common_properties")
    ElementTree.SubElement(properties, "e", name="tierod").text = json.dumps(metadata)
    return ElementTree.tostring(root, encoding="unicode")


def _signal_comment(channel: Channel) -> str:
    """The comment of a channel, from which its source and note are read again."""
    return f"tierod: {channel.source} | {channel.note}" if channel.source or channel.note else ""


WRITER = Writer("MF4", FromSpool(write_mf4), require_asammdf)
