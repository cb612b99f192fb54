"""MCAP: a topic per group of channels with common time stamps, as JSON messages with a schema."""

from __future__ import annotations

import heapq
import json
import math
from collections.abc import Iterator
from pathlib import Path

from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.core.recording import Channel
from tierod.io.layout import Writer
from tierod.io.libraries import require_library
from tierod.io.writers.spool import FromSpool, Spool, SpooledGroup


def require_mcap() -> None:
    """Raise MissingExtra where the library that writes MCAP is not installed."""
    require_library("mcap", "ros", "writing an MCAP file")


def schema_of(channels: tuple[Channel, ...] | list[Channel]) -> bytes:
    """The JSON schema of a message that holds one sample of every channel, with units."""
    properties = {each.name: {"type": "number", "unit": each.unit} for each in channels}
    return json.dumps({"type": "object", "properties": properties}).encode()


def write_mcap(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording as messages in the order of time; its description becomes metadata of the file.

    Args:
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold: fractions of a nanosecond
    """
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


WRITER = Writer("MCAP", FromSpool(write_mcap), require_mcap)
