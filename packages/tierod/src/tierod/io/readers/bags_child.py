"""Reader of ROS 1 and ROS 2 bags and MCAP files for the process of `tierod.io.readers.child`; imports no tierod."""

from __future__ import annotations

import json
import os
import re
import sqlite3
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple

SECONDS, MESSAGES = 0.05, 4000  # Computing time [s] and number of messages after which a piece is delivered
LONGEST = 32  # Length up to which an array in a message becomes columns; longer ones are images, scans and point clouds

# Number of messages of a topic, and computing time [s], for the search of fields where messages may differ
LOOKED, LOOK = 300, 0.5

SCANNED = 200_000  # Number of messages of an MCAP file without an index in which its topics are searched

# Pattern of an array without a fixed length in the definition of a message
_GROWS = re.compile(r"\[(<=\d+)?\]|sequence<")

# Units of vectors in the usual messages of ROS (REP 103)
_UNITS = {
    "angular_velocity": "rad/s",
    "linear_acceleration": "m/s**2",
    "angular": "rad/s",
    "linear": "m/s",
}


class Topic(NamedTuple):
    name: str  # name in the bag
    kind: str  # type of its messages
    encoding: str  # "ros1", "cdr" or "json"
    definition: str  # definition of the messages, where the bag holds it
    form: str  # form of the definition: "msg", "idl" or ""


class Message(NamedTuple):
    """A message: its topic, time of logging [ns], bytes, and share of the file that was read, 0 to 1."""

    topic: Topic
    stamp: int
    data: bytes
    share: float


class Reader:
    def __init__(self, path: str):
        self._path = path
        self._notes: list[str] = []
        self._columns: dict[str, tuple[Topic, str, str]] = {}
        self._decoders: dict[Topic, Any] = {}
        self._stores: dict[bool, Any] = {}
        self._listed: dict[str, set[str]] = {}
        self._looked: Counter[str] = Counter()
        self._texts: dict[str, None] = {}
        self._lanes: dict[int, Iterator[tuple[dict[str, Any], dict[str, Any]]]] = {}
        self._origin = 0

    @staticmethod
    def prepare() -> None:
        import rosbags.rosbag1
        import rosbags.typesys  # noqa: F401

    def answer(self, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(arrays, further metadata) in answer to a request for the content, or for the next piece of a lane."""
        if "lane" not in request:
            return {}, self._content()
        number = request["lane"]
        if number not in self._lanes:
            self._lanes[number] = self._pieces(request["names"], request["clock"])
        arrays, about = next(self._lanes[number], ({}, {"end": True}))
        return arrays, {"end": False, "notes": self._notes, **about}

    def _content(self) -> dict[str, Any]:
        """Columns found in the first messages of every topic: in a single one, where all messages are alike."""
        found: dict[str, dict[str, Any]] = {}
        first = None
        metadata: dict[str, str] = {}
        for message in self._first(metadata):
            first = message.stamp if first is None else min(first, message.stamp)
            self._looked[message.topic.name] += 1
            try:
                numbers = self._decoded(message, self._texts)
            except Exception as error:  # definitions and decoders of foreign messages fail in ways of their own
                reason = " ".join(str(error).split())[:80] or type(error).__name__
                note = f"the topic {message.topic.name} ({message.topic.kind}) cannot be decoded: {reason}"
                self._notes += [note] * (message.topic.name not in self._listed)
                self._listed.setdefault(message.topic.name, set())
                continue
            self._list(message.topic, numbers, found)
        self._origin = _origin(metadata, first or 0)
        return {
            "columns": list(found.values()),
            "notes": self._notes,
            "origin": self._origin / 1e9,
            "metadata": metadata,
            "texts": list(self._texts),
        }

    def _list(self, topic: Topic, numbers: dict[str, float], found: dict[str, dict[str, Any]]) -> None:
        known = self._listed.setdefault(topic.name, set())
        if numbers.keys() <= known:
            return
        known.update(numbers)
        units = _described(topic)
        for path in numbers:
            name = f"{topic.name.lstrip('/')}.{path}" if path else topic.name
            unit = units.get(path, _unit(path) if topic.encoding != "json" else "")
            self._columns.setdefault(name, (topic, path, unit))
            found.setdefault(name, {"name": name, "unit": unit, "title": path})

    def _done_with(self, topic: Topic, begun: float) -> bool:
        """Whether the fields of a topic are known; later messages in JSON, or with growing arrays, may have more."""
        listed = self._listed.get(topic.name)
        if listed is None:
            return False
        fixed = topic.encoding != "json" and not _GROWS.search(topic.definition or "[]")
        described = topic.encoding == "json" and bool(listed) and listed == _described(topic).keys()
        late = self._looked[topic.name] >= LOOKED or time.process_time() - begun > LOOK
        return fixed or described or late or not listed

    def _first(self, metadata: dict[str, str]) -> Iterator[Message]:
        """The first messages of every topic, until its fields are known."""
        if not self._path.endswith(".bag") and _begins(self._files()[0], b"\x89MCAP"):
            yield from self._first_of_mcap(metadata)
            return
        seen: set[str] = set()
        begun = time.process_time()
        for topics, messages in self._sources():
            for topic in topics:
                if topic.name not in seen:
                    for message in messages([topic]):
                        seen.add(topic.name)
                        yield message
                        if self._done_with(topic, begun):
                            break

    def _files(self) -> list[str]:
        if not os.path.isdir(self._path):
            return [self._path]
        names = [name for name in os.listdir(self._path) if name.endswith((".db3", ".mcap"))]
        if not names:
            raise ValueError("the folder holds neither a .db3 nor an .mcap file that is not packed")
        return [os.path.join(self._path, name) for name in sorted(names, key=_in_order)]

    def _pieces(self, names: list[str], clock: str) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """Arrays of the named columns, some messages at a time, and the share that was read."""
        import numpy as np

        wanted: dict[str, list[tuple[int, str]]] = {}
        for place, name in enumerate(names):
            topic, path, _ = self._columns[name]
            wanted.setdefault(topic.name, []).append((place, path))
        stamps: dict[str, list[float]] = {name: [] for name in wanted}
        values: dict[int, list[float]] = {place: [] for place in range(len(names))}

        def given(share: float) -> tuple[dict[str, Any], dict[str, Any]]:
            arrays = {}
            for number, (topic, members) in enumerate(wanted.items()):
                if stamps[topic]:
                    arrays[f"t{number}"] = np.array(stamps[topic], dtype="<f8")
                    arrays |= {str(place): np.array(values[place], dtype="<f8") for place, _ in members}
                    stamps[topic].clear()
                    for place, _ in members:
                        values[place].clear()
            return arrays, {"share": share, "clocks": [[place for place, _ in each] for each in wanted.values()]}

        begun, count, share, lost = time.process_time(), 0, 0.0, 0
        further: dict[str, set[str]] = {}
        for message in self._messages(set(wanted)):
            try:
                numbers = self._decoded(message)
            except Exception:  # as above; messages that cannot be decoded are counted and reported
                lost += 1
                continue
            if not numbers.keys() <= self._listed[message.topic.name]:
                found = further.setdefault(message.topic.name, set())
                found |= numbers.keys() - self._listed[message.topic.name]
            logged = (message.stamp - self._origin) / 1e9
            stamps[message.topic.name].append(numbers[clock] - self._origin / 1e9 if clock in numbers else logged)
            for place, path in wanted[message.topic.name]:
                values[place].append(numbers.get(path, float("nan")))
            count, share = count + 1, message.share
            if count >= MESSAGES or (count % 64 == 0 and time.process_time() - begun > SECONDS):
                yield given(share)
                begun, count = time.process_time(), 0
        if lost:
            self._notes.append(f"{lost} messages that cannot be decoded were left out")
        for topic_name, paths in further.items():
            some = ", ".join(sorted(paths)[:3]) + (f" and {len(paths) - 3} more" if len(paths) > 3 else "")
            self._notes.append(f"fields of {topic_name} that came only later were left out: {some}")
        yield given(1.0)

    def _messages(self, names: set[str]) -> Iterator[Message]:
        for topics, messages in self._sources():
            yield from messages([topic for topic in topics if topic.name in names])

    def _sources(self) -> Iterator[tuple[list[Topic], Any]]:
        """(topics, function from some of them to their messages) of every file, in order."""
        for path in self._files():
            if _begins(path, b"#ROSBAG"):
                yield self._ros1(path)
            elif _begins(path, b"\x89MCAP"):
                yield self._mcap(path)
            else:
                yield self._ros2(path)

    def _ros1(self, path: str) -> tuple[list[Topic], Any]:
        from pathlib import Path

        from rosbags.rosbag1 import Reader as Bag

        bag = Bag(Path(path))
        bag.open()
        topics = {each.id: Topic(each.topic, each.msgtype, "ros1", each.msgdef.data, "msg") for each in bag.connections}
        begin, span = bag.start_time, max(bag.duration, 1)

        def messages(chosen: list[Topic]) -> Iterator[Message]:
            wanted = [each for each in bag.connections if topics[each.id] in chosen]
            if wanted:
                for each, stamp, data in bag.messages(wanted):
                    yield Message(topics[each.id], stamp, data, min((stamp - begin) / span, 1.0))

        return list(dict.fromkeys(topics.values())), messages

    def _ros2(self, path: str) -> tuple[list[Topic], Any]:
        file = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
        rows = file.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        known: dict[str, tuple[str, str]] = {}
        if file.execute("SELECT 1 FROM sqlite_master WHERE name = 'message_definitions'").fetchone():
            query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            known = {kind: (str(text), str(form)) for kind, form, text in file.execute(query)}
        topics = {}
        for number, name, kind, encoding in rows:
            text, form = known.get(kind, ("", ""))
            topics[number] = Topic(str(name), str(kind), str(encoding), text, form.removeprefix("ros2"))
        last = file.execute("SELECT max(id) FROM messages").fetchone()[0] or 1

        def messages(chosen: list[Topic]) -> Iterator[Message]:
            numbers = [number for number, topic in topics.items() if topic in chosen]
            marks = ",".join("?" * len(numbers))
            query = f"SELECT topic_id, timestamp, data, id FROM messages WHERE topic_id IN ({marks}) ORDER BY id"
            for number, stamp, data, place in file.execute(query, numbers):
                yield Message(topics[number], int(stamp), bytes(data), min(place / last, 1.0))

        return list(topics.values()), messages

    def _mcap(self, path: str) -> tuple[list[Topic], Any]:
        def messages(chosen: list[Topic]) -> Iterator[Message]:
            names = {topic.name for topic in chosen}
            return (each for each in self._records(path, {}) if each.topic.name in names)

        return [topic for topic, _, _ in self._columns.values()], messages

    def _first_of_mcap(self, metadata: dict[str, str]) -> Iterator[Message]:
        done: set[str] = set()
        begun = time.process_time()
        for path in self._files():
            expected = _topics_in_summary(path)
            for count, message in enumerate(self._records(path, metadata)):
                name = message.topic.name
                if name not in done:
                    yield message
                    if self._done_with(message.topic, begun):
                        done.add(name)
                late = time.process_time() - begun > LOOK and expected <= self._looked.keys()
                if count > SCANNED or (expected and (expected <= done or late)):
                    break

    def _records(self, path: str, metadata: dict[str, str]) -> Iterator[Message]:
        """The messages of an MCAP file in the order of the file, up to where it is cut off."""
        from mcap.records import Channel, Metadata, Schema
        from mcap.records import Message as Record
        from mcap.stream_reader import StreamReader

        schemas: dict[int, Any] = {}
        topics: dict[int, Topic] = {}
        size = max(os.path.getsize(path), 1)
        with open(path, "rb") as file:
            try:
                for record in StreamReader(file, record_size_limit=1 << 28).records:
                    if isinstance(record, Record) and record.channel_id in topics:
                        share = min(file.tell() / size, 1.0)
                        yield Message(topics[record.channel_id], record.log_time, record.data, share)
                    elif isinstance(record, Schema):
                        schemas[record.id] = record
                    elif isinstance(record, Channel):
                        topics[record.id] = _topic_of(record, schemas.get(record.schema_id))
                    elif isinstance(record, Metadata) and record.name == "tierod":
                        metadata |= record.metadata
            except Exception as error:  # errors of the library, of struct and of the decompressors
                if not topics:
                    raise
                reason = " ".join(str(error).split())[:60] or type(error).__name__
                note = f"the file is cut off or damaged ({reason}): the data before that were read"
                if note not in self._notes:
                    self._notes.append(note)

    def _decoded(self, message: Message, texts: dict[str, None] | None = None) -> dict[str, float]:
        """The numbers in a message by their path; the columns that hold text are added to `texts`."""
        topic = message.topic
        if topic not in self._decoders:
            self._decoders[topic] = self._decoder(topic)
        numbers: dict[str, float] = {}
        found: list[str] = []
        _flatten("", self._decoders[topic](message.data), numbers, found)
        if texts is not None:
            texts |= {f"{topic.name.lstrip('/')}.{path}" if path else topic.name: None for path in found}
        return numbers

    def _decoder(self, topic: Topic) -> Any:
        if topic.encoding == "json":
            return json.loads
        if topic.encoding not in ("ros1", "cdr"):
            raise ValueError(f"messages in the encoding '{topic.encoding or 'unknown'}' are not read")
        store = self._store(topic.encoding == "ros1")
        kind = topic.kind if "/msg/" in topic.kind else topic.kind.replace("/", "/msg/", 1)
        if kind not in store.fielddefs and topic.definition:
            from rosbags.typesys import get_types_from_idl, get_types_from_msg

            idl = topic.form.endswith("idl")
            types = get_types_from_idl(topic.definition) if idl else get_types_from_msg(topic.definition, kind)
            store.register({name: each for name, each in types.items() if name not in store.fielddefs})
        if kind not in store.fielddefs:
            raise ValueError("the bag does not describe this message, and it is none of the usual ones")
        if topic.encoding == "ros1":
            return lambda data: store.deserialize_ros1(data, kind)
        return lambda data: store.deserialize_cdr(data, kind)

    def _store(self, first: bool) -> Any:
        from rosbags.typesys import Stores, get_typestore

        if first not in self._stores:
            self._stores[first] = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
        return self._stores[first]


def _flatten(path: str, value: Any, into: dict[str, float], texts: list[str]) -> None:
    """Collect every number below a value by its path, and the paths of texts; a time stamp is one number [s]."""
    if isinstance(value, bool | int | float):
        into[path] = float(value)
    elif isinstance(value, str):
        texts.append(path)
    elif value is None:
        into[path] = float("nan")
    elif isinstance(value, dict):
        for name, entry in value.items():
            _flatten(f"{path}.{name}" if path else str(name), entry, into, texts)
    elif isinstance(value, list | tuple) or hasattr(value, "tolist"):
        entries = value if isinstance(value, list | tuple) else value.tolist()
        if isinstance(entries, list | tuple) and len(entries) <= LONGEST:
            for place, entry in enumerate(entries):
                _flatten(f"{path}[{place}]", entry, into, texts)
        elif not isinstance(entries, list | tuple):
            _flatten(path, entries, into, texts)
    elif hasattr(value, "nanosec") and hasattr(value, "sec"):
        into[path] = value.sec + 1e-9 * value.nanosec
    elif hasattr(value, "__dataclass_fields__"):
        # Constants of a message are class variables, and no fields.
        for name in (field.name for field in fields(value)):
            if name != "__msgtype__":
                _flatten(f"{path}.{name}" if path else name, getattr(value, name), into, texts)


def _origin(metadata: dict[str, str], first: int) -> int:
    """Calendar time of the time zero [ns]: as tierod wrote it, else the full second before the first message."""
    try:
        origin = float(json.loads(metadata["description"])["origin"])
        # Seconds and fraction apart: nanoseconds since 1970 exceed the 53 bits of a float.
        return round(origin) * 10**9 + round((origin - round(origin)) * 1e9)
    except (KeyError, ValueError, TypeError, OverflowError):
        return first // 10**9 * 10**9


def _topic_of(channel: Any, schema: Any) -> Topic:
    encoding = channel.message_encoding or ("cdr" if schema and schema.encoding.startswith("ros2") else "")
    text = schema.data.decode("utf-8", "replace") if schema else ""
    form = schema.encoding if schema else ""
    return Topic(channel.topic, schema.name if schema else "", encoding, text, form.removeprefix("ros2"))


def _described(topic: Topic) -> dict[str, str]:
    """Units by path, from a JSON schema that states them."""
    try:
        properties = json.loads(topic.definition)["properties"] if topic.encoding == "json" else {}
        return {name: each["unit"] for name, each in properties.items() if isinstance(each.get("unit"), str)}
    except (ValueError, KeyError, TypeError, AttributeError):
        return {}


def _unit(path: str) -> str:
    *above, last = path.split(".")
    return _UNITS.get(above[-1], "") if above and last in ("x", "y", "z") else ""


def _topics_in_summary(path: str) -> set[str]:
    """Topics with messages, from the index at the end of an MCAP file; empty without an index."""
    from mcap.reader import make_reader

    try:
        with open(path, "rb") as file:
            summary = make_reader(file).get_summary()
            if summary is None or summary.statistics is None:
                return set()
            counts = summary.statistics.channel_message_counts
            return {each.topic for number, each in summary.channels.items() if counts.get(number)}
    except Exception:  # a damaged index counts as none: the messages themselves are read then
        return set()


def _begins(path: str, beginning: bytes) -> bool:
    with open(path, "rb") as file:
        return file.read(len(beginning)) == beginning


def _in_order(name: str) -> tuple[int, str]:
    """Sort key by the number at the end of the name, which recorders append when they split a bag."""
    digits = "".join(each for each in name.rpartition("_")[2] if each.isdigit())
    return int(digits or 0), name
