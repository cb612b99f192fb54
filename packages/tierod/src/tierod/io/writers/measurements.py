"""MF4 through asammdf, and MCAP as JSON messages: a channel group or topic per group of channels with common stamps."""

from __future__ import annotations

import datetime
import heapq
import json
import math
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

from tierod.core.errors import MissingExtra, OutputError
from tierod.core.files import replacing
from tierod.core.recording import Channel
from tierod.io.formats import Writer, require_library
from tierod.io.writers.spool import FromSpool, Spool, SpooledGroup


def write_mf4(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to an MF4 file; sources and notes become comments of channels, metadata that of the file."""
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


MF4 = Writer("MF4", FromSpool(write_mf4), require_asammdf)


def require_mcap() -> None:
    require_library("mcap", "ros", "writing an MCAP file")


def schema_of(channels: tuple[Channel, ...] | list[Channel]) -> bytes:
    """The JSON schema of a message that holds one sample of every channel, with units."""
    properties = {each.name: {"type": "number", "unit": each.unit} for each in channels}
    return json.dumps({"type": "object", "properties": properties}).encode()


def write_mcap(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording as messages in the order of time; its description becomes metadata of the file."""
    require_mcap()
    from mcap.writer import CompressionType
    from mcap.writer import Writer as Messages

    found = spool.groups()
    about = spool.description(found)
    # Whole seconds as an integer: nanoseconds since 1970 exceed the 53 bits of a float.
    start = round(about["origin"]) * 10**9
    part = about["origin"] - round(about["origin"])
    with replacing(path) as temporary, temporary.open("wb") as file:
        writer = Messages(file, compression=CompressionType.ZSTD)
        writer.start(library="tierod")
        writer.add_metadata("tierod", {"description": json.dumps(about)})
        topics = []
        for number, group in enumerate(found):
            name = f"group_{number + 1}"
            schema = writer.register_schema(name=name, encoding="jsonschema", data=schema_of(group.channels))
            topics.append(writer.register_channel(topic=f"/{name}", message_encoding="json", schema_id=schema))
        for sequence, (time, number, text) in enumerate(heapq.merge(*map(_messages, range(len(found)), found))):
            stamp = start + round((time + part) * 1e9)
            if stamp < 0:
                raise OutputError(
                    f"{path} cannot be written: MCAP has no time before 1970, but the recording begins earlier"
                )
            writer.add_message(topics[number], stamp, text, stamp, sequence)
        writer.finish()  # type: ignore[no-untyped-call]  # the library has no annotation there
    return ("MCAP holds time stamps in whole nanoseconds",)


def _messages(number: int, group: SpooledGroup) -> Iterator[tuple[float, int, bytes]]:
    names = [json.dumps(each.name) for each in group.channels]
    for time, values in group.rows():
        rows = zip(*(part.tolist() for part in values), strict=True)
        for stamp, row in zip(time.tolist(), rows, strict=True):
            # JSON has no NaN: a missing sample is null.
            texts = (repr(value) if math.isfinite(value) else "null" for value in row)
            pairs = ",".join(f"{name}:{text}" for name, text in zip(names, texts, strict=True))
            yield stamp, number, f"{{{pairs}}}".encode()


MCAP = Writer("MCAP", FromSpool(write_mcap), require_mcap)
