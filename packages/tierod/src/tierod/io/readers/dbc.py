"""Databases of CAN messages (DBC), and the decoding of the messages that a log holds."""

from __future__ import annotations

import logging
import re
import warnings
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.errors import InputError, MissingExtra
from tierod.core.recording import Channel
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes
from tierod.io.formats import muted
from tierod.io.readers.frames import EXTENDED, IDENTIFIERS, Frames, Heard, InOrder, Log, identifier_text, messages
from tierod.io.readers.payloads import LONGEST, Payloads, span
from tierod.io.readers.source import Column, Lane, Piece, Source

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal
    from cantools.database.can.database import Database as CanDatabase
    from cantools.database.diagnostics.database import Database as DiagnosticsDatabase


_MOST_NAMED = 4  # Most signals or statements that a remark names
_KINDS = ("arxml", "dbc", "kcd", "sym", "cdd")
_ENTRY = re.compile(r"""\b(VAL_|SIG_VALTYPE_)\s+(\d+)\s+(\w+)\b(?:"(?:[^"\\]|\\.)*"|[^;"])*;""")


_NULL_ADDRESS = 0xFE  # J1939-81: address of a sender that has claimed none

# J1939-21: below this PDU format the next byte is the address of the receiver, not part of the parameter group
_PGN_WITH_ADDRESS = 240

# Pattern of the names that databases give to states without a value
_SAYS_NOTHING = re.compile(
    r"not[ _-]*(avail|defin|install|support|used)|n/?a\b|sna\b|error|fault|invalid|reserved|undefined"
    r"|do ?n.?o?t[ _-]*care|no[ _-]*action|(un|not[ _-]*)init|\binit|unavail|no[ _-]*(value|data|signal)"
    r"|unknown|fehler|ung(ü|ue)ltig|nicht[ _-]*(verf|vorh|def|init|belegt)|unbekannt|unbelegt|reserviert"
    r"|erreur|d(é|e)faut|invalide|non[ _-]*(disp|valide|d(é|e)fini|utilis)|indisponible|inconnu|r(é|e)serv(é|e)",
    re.IGNORECASE,
)

# Least length of a signal [bits] whose numbers count although some have names; shorter ones hold states
_COUNTS = 5


def parameter_group(identifier: int) -> int:
    group = (identifier >> 8) & 0x3FFFF
    return group & 0x3FF00 if (group >> 8) & 0xFF < _PGN_WITH_ADDRESS else group


def without_value(message: Message, item: Signal, raw: np.ndarray) -> np.ndarray | None:
    """Mask of values that the sender marks as not available or in error; None where the signal has no such code.

    The value table of a signal says so by its names, unless most numbers have one: that is a list of states. In J1939
    the ranges of its signals say so too.
    """
    masks = [] if message.protocol != "j1939" or (coded := _j1939_silent(item, raw)) is None else [coded]
    names: Mapping[int, object] = item.choices or {}
    if item.length >= _COUNTS and not item.is_float and 2 * len(names) < 1 << item.length:
        silent = [state for state, name in names.items() if _SAYS_NOTHING.search(str(name))]
        masks += [raw == raw.dtype.type(state) for state in silent if _holds(raw.dtype, state)]
    return np.logical_or.reduce(masks) if masks else None


def _holds(kind: np.dtype, number: int) -> bool:
    limits = np.iinfo(kind)
    return limits.min <= number <= limits.max


def _j1939_silent(item: Signal, raw: np.ndarray) -> np.ndarray | None:
    """Mask of values outside the range of a signal; None where it has no such range.

    J1939-71, ranges of transmitted signals: a parameter of one byte is in error at 0xFE and not available at 0xFF, a
    longer one where its highest byte is. Discrete parameters of two bits: 0b10 error (of a command: reserved),
    0b11 not available (of a command: take no action). Of four bits: 0xE error, 0xF not available (SPN 1675).
    Of 3, 5, 6 and 7 bits only all ones is not available: the value below may be a state (SPN 527, 0b110: accelerator
    override). One bit cannot code it. Commands that use all four states of two bits exist (SPN 695): a state that the
    database names otherwise than error or not available is kept.

    Args:
        raw: its raw values, shape (n,); unsigned for a signal that has such codes
    """
    if item.is_signed or item.is_float or not 2 <= item.length <= LONGEST:
        return None
    if item.length >= 8:
        return raw >= np.uint64(0xFE << (item.length - 8))
    ones = (1 << item.length) - 1
    states = (ones - 1, ones) if item.length in (2, 4) else (ones,)
    names: Mapping[int, object] = item.choices or {}
    silent = [state for state in states if state not in names or _SAYS_NOTHING.search(str(names[state]))]
    return np.isin(raw, np.array(silent, dtype=np.uint64)) if silent else None


@dataclass(frozen=True)
class Found:
    message: Message  # description of the message by cantools
    prefix: str  # prefix of the names of its signals
    where: str  # identifier and bus, for the source of a channel


class Database(list["Message"]):
    """Messages of databases; `notes` names what was left out of them."""

    def __init__(self, messages: Iterable[Message] = (), notes: Sequence[str] = ()):
        super().__init__(messages)
        self.notes = tuple(notes)


def load_databases(paths: Sequence[str | Path]) -> Database:
    try:
        import cantools  # noqa: F401
    except ImportError:
        raise MissingExtra("cantools", "can", "decoding a CAN log") from None
    found: list[Message] = []
    notes: list[str] = []
    for path in paths:
        content = read_bytes(path, "the CAN database", most=MOST_DATA_BYTES)
        try:
            # cantools warns of duplicate names, but here identifiers decide.
            with muted("cantools", logging.ERROR), warnings.catch_warnings(action="ignore"):
                loaded, left_out = _database(Path(path), content)
        except Exception as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"{path} is not a CAN database that can be read: {reason}; give a DBC file") from None
        described_here = list(getattr(loaded, "messages", []))
        # Without its attribute a database of J1939 is known by its identifiers, which all have the null address.
        if all(each.is_extended_frame and each.frame_id & 0xFF == _NULL_ADDRESS for each in described_here):
            for each in described_here:
                each.protocol = "j1939"
        found += described_here
        some = "; ".join(left_out[:_MOST_NAMED]) + f"; and {len(left_out) - _MOST_NAMED} more" * (
            len(left_out) > _MOST_NAMED
        )
        notes += [f"left out of {Path(path).name}: {some}"] if left_out else []
    if not found:
        raise InputError(f"{', '.join(map(str, paths))} describes no CAN message; give the DBC of this vehicle")
    return Database(found, notes)


_STATEMENT = re.compile(r"\s*(BO_|SG_|[A-Z]{2,}_[A-Z_]*)(?=\s)")
_IDENTIFIED = re.compile(r"\b((?:BO_|SG_|VAL_|BO_TX_BU_|SIG_VALTYPE_|SIG_GROUP_|SG_MUL_VAL_)\s+)(\d{4,9})(?=[\s:])")
_MOST_LEFT_OUT = 20  # Statements of a database that may be left out, each of which costs a further parse


def _database(path: Path, content: bytes) -> tuple[CanDatabase | DiagnosticsDatabase, list[str]]:
    """A database, and the statements of a DBC that cantools refuses and that are left out.

    DBC and SYM files are in Windows-1252, unless their signs beyond ASCII are valid UTF-8; all others are in UTF-8.
    """
    import cantools.database

    kind = path.suffix[1:].lower()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252" if kind in ("dbc", "sym") else "utf-8", errors="replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    left_out: list[str] = []
    attempts = 0
    while True:
        try:
            return cantools.database.load_string(text, kind if kind in _KINDS else None, strict=False), left_out
        except cantools.database.UnsupportedDatabaseFormatError as error:  # type: ignore[attr-defined]  # not re-exported
            shorter = _without_refused(text, str(error), left_out) if kind == "dbc" else None
            attempts += 1
            if shorter is None or shorter == text or attempts > _MOST_LEFT_OUT:
                raise
            text = shorter


def _without_refused(text: str, error: str, left_out: list[str]) -> str | None:
    """A DBC without the statement that an error is about, or with its meaning; None where it names no statement."""
    if "unused" in error and (orphans := set(re.findall(r"(VAL_|SIG_VALTYPE_) (\d+) (\w+)", error))):
        return _ENTRY.sub(lambda entry: "" if entry.groups() in orphans else entry[0], text)
    if "more than 11 bits" in error:
        # An identifier above 0x7FF without the bit of extended ones can only be an extended one.
        extended = _IDENTIFIED.sub(lambda found: f"{found[1]}{_extended(int(found[2]))}", text)
        if extended != text:
            return extended
    place = re.search(r"line (\d+), column", error)
    lines = text.split("\n")
    if "bits in message" in error:
        titles = ((at, re.match(r"\s*BO_\s+(\d+)\s", line)) for at, line in enumerate(lines))
        impossible = [at for at, title in titles if title and int(title[1]) & ~EXTENDED >= IDENTIFIERS]
        for first in impossible:
            _leave_out(lines, first, left_out)
        return "\n".join(lines) if impossible else None
    if not place or not 0 < int(place[1]) <= len(lines):
        return None
    first = next((at for at in range(int(place[1]) - 1, -1, -1) if _STATEMENT.match(lines[at])), -1)
    if first < 0:
        return None
    _leave_out(lines, first, left_out)
    return "\n".join(lines)


def _leave_out(lines: list[str], first: int, left_out: list[str]) -> None:
    """Empty the lines of the statement that begins at one of them, of a message with those of its signals."""
    inside = lines[first].lstrip().startswith("BO_ ")
    after = first + 1
    while after < len(lines) and ((found := _STATEMENT.match(lines[after])) is None or (inside and found[1] == "SG_")):
        after += 1
    words = re.findall(r"[\w.]+", lines[first])
    what = {"BO_": "message", "SG_": "signal"}.get(words[0], words[0])
    name = words[2 if words[0] == "BO_" else 1] if len(words) > 2 else ""
    left_out.append(f"line {first + 1}: {what} '{name}'")
    lines[first:after] = [""] * (after - first)


def _extended(identifier: int) -> int:
    return identifier | 1 << 31 if 0x7FF < identifier < 1 << 29 else identifier


def match_messages(log: Heard, database: Sequence[Message]) -> dict[tuple[int, int], Found]:
    """The messages of a database that a log holds, one per message, bus and sender, by bus and identifier."""
    exact = {message.frame_id | (EXTENDED if message.is_extended_frame else 0): message for message in database}
    groups = {parameter_group(message.frame_id): message for message in database if message.protocol == "j1939"}
    found: dict[tuple[int, int], Found] = {}
    seen = set()
    ids: dict[int, int] = {}
    for (bus, identifier), count in log.counts.items():
        ids[identifier] = ids.get(identifier, 0) + count
        message = exact.get(identifier)
        # In J1939, priority and sender in an identifier may differ from those in the database.
        if message is None and identifier & EXTENDED:
            message = groups.get(parameter_group(identifier & ~EXTENDED))
        if message is None or message.is_container:
            continue
        where = f"{identifier_text(identifier)} on {log.buses[bus]}"
        prefix = message.name
        if message.name in seen:
            prefix = f"{log.buses[bus]}:{identifier_text(identifier)}:{message.name}"
        seen.add(message.name)
        found[bus, identifier] = Found(message, prefix, where)
    if not found:
        raise InputError(_no_match(ids, exact))
    return found


def _no_match(log: dict[int, int], database: Collection[int]) -> str:
    def some(ids: list[int]) -> str:
        text = ", ".join(identifier_text(identifier) for identifier in ids[:6])
        return text + (f" and {len(ids) - 6} more" if len(ids) > 6 else "")

    frequent = sorted(log, key=lambda identifier: -log[identifier])
    return (
        f"the DBC matches no frame of the log: the log holds {some(frequent)}, the DBC {some(sorted(database))}; "
        "give the DBC of this vehicle and bus"
    )


@dataclass(frozen=True)
class Described:
    """Description of the frames of a bus by databases."""

    found: dict[tuple[int, int], Found]  # messages in the log, by bus and identifier
    # (bus and identifier of its message, signal) of every signal in the log, by the name of its column
    places: dict[str, tuple[tuple[int, int], Signal]]
    columns: tuple[Column, ...]  # columns "Message.Signal"
    silent: tuple[str, ...]  # names of the columns of messages that are not in the log

    def wanted(self, names: Sequence[str]) -> dict[tuple[int, int], list[tuple[str, Signal]]]:
        wanted: dict[tuple[int, int], list[tuple[str, Signal]]] = {}
        for name in names:
            key, item = self.places[name]
            wanted.setdefault(key, []).append((name, item))
        return wanted


def described(content: Heard, database: Sequence[Message]) -> Described:
    """Description of the received frames by databases.

    A message on several buses or from several senders keeps its plain name for the first, the others get a prefix.
    """
    found = match_messages(content, database)
    places = {
        f"{entry.prefix}.{item.name}": (key, item) for key, entry in found.items() for item in entry.message.signals
    }
    columns = tuple(Column(name, item.unit or "", item.name, True) for name, (_, item) in places.items())
    came = {entry.message.name for entry in found.values()}
    silent = tuple(f"{each.name}.{item.name}" for each in database if each.name not in came for item in each.signals)
    return Described(found, places, columns, silent)


def bus_source(log: Log, content: Heard, database: Database, metadata: Mapping[str, object]) -> Source:
    """A CAN log with its database as a source of columns named "Message.Signal"."""
    known = described(content, database)
    silent: Counter[str] = Counter()

    def lanes(names: Sequence[str]) -> list[Lane]:
        silent.clear()
        return [_decoded(log, content, known, known.wanted(names), silent)]

    def found() -> tuple[str, ...]:
        some = ", ".join(f"{count} of {name}" for name, count in silent.most_common(_MOST_NAMED) if count)
        more = len(+silent) - _MOST_NAMED
        others = f" and of {more} other signals" if more > 0 else ""
        return (f"values that the database names as not available or in error are missing: {some}{others}",) * bool(
            some
        )

    metadata = {**metadata, "frames": content.frames, "messages": len(known.found), "buses": content.buses}
    notes = (*content.notes, *database.notes)
    return Source(known.columns, lanes, metadata, content.origin, notes, found, silent=known.silent)


def _decoded(
    log: Log,
    content: Heard,
    known: Described,
    wanted: dict[tuple[int, int], list[tuple[str, Signal]]],
    silent: Counter[str],
) -> Lane:
    """The wanted signals of a log, block by block; the first piece has all without samples: a message may come late.

    `silent` counts the values that name none, by signal.
    """
    found = known.found
    yield Piece([channel for key, items in wanted.items() for channel in silent_channels(found[key], items)])
    done = 0
    for frames in InOrder(log):
        channels = []
        for identifier, bus, index in messages(frames):
            if (bus, identifier) in wanted:
                rows = Rows.of(frames, index)
                entry = found[bus, identifier]
                decoded = [channel_of(name, entry, item, rows) for name, item in wanted[bus, identifier]]
                if rows.shortest >= entry.message.length:
                    silent.update({each.name: int(np.count_nonzero(np.isnan(each.values))) for each in decoded})
                channels += decoded
        done += len(frames)
        yield Piece(channels, done / content.frames)


@dataclass(frozen=True)
class Rows:
    time: np.ndarray  # [s], shape (n,)
    payloads: Payloads  # bytes of the frames
    length: np.ndarray  # number of bytes of each payload, shape (n,)
    shortest: int  # smallest of these numbers

    @staticmethod
    def of(frames: Frames, index: np.ndarray) -> Rows:
        length = frames.length[index]
        return Rows(frames.time[index], Payloads(frames.payload[index]), length, int(length.min()))


def silent_channels(entry: Found, items: Sequence[tuple[str, Signal]]) -> list[Channel]:
    """Signals of a message, without samples; those that every frame carries share their time stamps."""
    none = np.empty((0, 8), dtype=np.uint8)
    rows = Rows(np.empty(0), Payloads(none), np.empty(0, dtype=int), 8)
    return [channel_of(name, entry, item, rows) for name, item in items]


def channel_of(name: str, entry: Found, item: Signal, rows: Rows) -> Channel:
    time, values = rows.time, physical(entry.message, item, rows)
    chosen = selected(entry.message, item, rows)
    if chosen is not None:
        time, values = time[chosen], values[chosen]
    return Channel(name, time, values, item.unit or "", f"{name} ({entry.where})")


def selected(message: Message, item: Signal, rows: Rows) -> np.ndarray | None:
    """Mask of frames that carry a multiplexed signal; None where all do. Multiplexers may be multiplexed themselves."""
    if not item.multiplexer_ids or not item.multiplexer_signal:
        return None
    selector = message.get_signal_by_name(item.multiplexer_signal)
    mask = np.isin(_raw(selector, rows), np.array(item.multiplexer_ids, dtype=np.uint64))
    mask &= rows.length >= bytes_of(selector)
    above = selected(message, selector, rows)
    return mask if above is None else mask & above


def physical(message: Message, item: Signal, rows: Rows) -> np.ndarray:
    raw = _raw(item, rows)
    with np.errstate(all="ignore"):
        values = raw.astype(float)
        if item.scale != 1:
            values *= float(item.scale)
        if item.offset != 0:
            values += float(item.offset)
    if rows.shortest < bytes_of(item):
        values[rows.length < bytes_of(item)] = np.nan
    silent = without_value(message, item, raw)
    if silent is not None:
        values[silent] = np.nan
    return values


def _raw(item: Signal, rows: Rows) -> np.ndarray:
    big_endian = item.byte_order == "big_endian"
    return rows.payloads.raw(item.start, item.length, big_endian, bool(item.is_signed), bool(item.is_float))


def bytes_of(item: Signal) -> int:
    return -(-span(item.start, item.length, item.byte_order == "big_endian")[1] // 8)
