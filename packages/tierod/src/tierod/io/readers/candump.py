"""Text of `candump -L`, lines as "(1600000000.000100) can0 123#0102", and of `candump -t`, as it prints them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.csv import instant
from tierod.io.readers.frames import EXTENDED, Frames, Log, Remembered, bus_number, only_notes
from tierod.io.readers.source import Format, text_begin

LINE = re.compile(rb"^\(\d+\.\d+\) +\S+ +[0-9A-Fa-f]{3,8}#", re.MULTILINE)

# Eighteen digits fit into 64 bits. After "##" and its flags comes a payload of CAN FD, after "#R" none.
_LINE = re.compile(
    rb"^\((\d{1,18})\.(\d{1,18})\) +(\S++) +([\dA-Fa-f]{3,8}+)#(?:#[\dA-Fa-f])?"
    rb"((?:[\dA-Fa-f]{2}){0,64}+|R\w*)(?: [RT])?[ \r]*$",
    re.MULTILINE,
)
# As printed: "(1600000000.000100)  can0  RX - -  123   [2]  01 02   '..'"; without -t it has no time
_PRINTED = re.compile(
    rb"^ *(?:\((\d{1,18}\.\d{1,18}|\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{1,9})\))?"
    rb" +(\S+) +(?:[RT]X +[-BE] +[-BE] +)?([0-9A-Fa-f]{3,8}) +\[(\d+)\]"
    rb"((?: +[0-9A-Fa-f]{2})*)( +remote request)?(?: +'.*')?[ \r]*$",
    re.MULTILINE,
)
_DELTAS = 0.1  # Share of stamps that do not grow from which they are times since the frame before (`candump -td`)
_ERROR_FRAME, _ID = 0x20000000, 0x1FFFFFFF


def frames_of(blocks: Iterable[bytes]) -> Iterator[Frames]:
    """The frames of a log in blocks of whole lines, their time counted from the first; the last has notes on losses."""
    names: dict[bytes, int] = {}
    first: tuple[float, float] | None = None
    frames: Frames | None = None
    lines, good, untimed = 0, 0, False
    for block in _as_logged(blocks):
        rows = _LINE.findall(block)
        lines, good = lines + sum(map(bool, block.splitlines())), good + len(rows)
        # Remote frames and error frames are whole lines without a signal.
        errors = {name for name in {row[3] for row in rows} if len(name) == 8 and int(name, 16) & _ERROR_FRAME}
        rows = [row for row in rows if row[4][:1] != b"R" and row[3] not in errors]
        if not rows:
            untimed = untimed or _PRINTED.search(block) is not None
            continue
        # By columns, and whatever repeats by a table of its few values: Python's time per frame decides here.
        seconds, fraction, bus, identifier, data = ([row[k] for row in rows] for k in range(5))
        # Seconds and fraction are subtracted apart, so that the large calendar time takes no digit of the fraction.
        whole = _mapped({text: int(text) for text in set(seconds)}, seconds, float)
        part = np.fromiter(map(int, fraction), float) / 10.0 ** np.fromiter(map(len, fraction), float)
        first = first or (float(whole[0]), float(part[0]))
        buses = {name: bus_number(names, name) for name in dict.fromkeys(bus)}
        known = {name: int(name, 16) & _ID | (EXTENDED if len(name) > 3 else 0) for name in set(identifier)}
        length = np.fromiter(map(len, data), int) // 2
        payload = np.zeros((len(data), max(8, int(length.max()))), dtype=np.uint8)
        payload[np.arange(payload.shape[1]) < length[:, None]] = np.frombuffer(
            bytes.fromhex(b"".join(data).decode("ascii")), dtype=np.uint8
        )
        frames = Frames(
            (whole - first[0]) + (part - first[1]),
            _mapped(known, identifier, np.uint32),
            _mapped(buses, bus, np.uint16),
            payload,
            length,
            tuple(name.decode("latin-1") for name in names),
            first[0] + first[1],
        )
        yield frames
    if frames is None:
        why = "no time stamps" if untimed else "no CAN frame as `candump -L` writes it, (seconds) interface id#data"
        raise InputError(f"the log holds {why}; record it with `candump -L`")
    if lines > good:
        yield only_notes(frames, (f"{lines - good} of {lines} lines of the log are broken and were left out",))


def _as_logged(blocks: Iterable[bytes]) -> Iterator[bytes]:
    """Blocks of lines as `candump -L` writes them."""
    deltas: bool | None = None
    now = 0.0
    for block in blocks:
        printed = [row[0] for row in _PRINTED.findall(block) if row[0]] if b"[" in block else []
        if not printed:
            yield block
            continue
        if b"-" in printed[0]:  # calendar times (`candump -tA`)
            printed = [b"%.6f" % instant(each.decode()) if b"-" in each else each for each in printed]
        stamps = np.array(list(map(float, printed)))
        if deltas is None:
            deltas = stamps[0] < 1.0 and len(stamps) > 1 and bool(np.mean(np.diff(stamps[1:]) <= 0.0) > _DELTAS)
        if deltas:
            stamps = now + np.cumsum(stamps)
            now = float(stamps[-1])
        times = iter([b"%.6f" % each for each in stamps] if deltas else printed)

        def line(found: re.Match[bytes], times: Iterator[bytes] = times) -> bytes:
            if not found[1]:
                return found[0]
            data = b"R" if found[6] else b"".join(found[5].split())
            return b"(%s) %s %s#%s" % (next(times), found[2], found[3], data)

        yield _PRINTED.sub(line, block)


def _mapped(numbers: dict[bytes, int], names: list[bytes], kind: type) -> np.ndarray:
    return np.fromiter(map(numbers.__getitem__, names), kind, len(names))


def _log(content: Content, _: object) -> Log:
    return Log(content.path.name, Remembered(lambda: frames_of(whole_lines(content.blocks(), content.path))))


FORMAT = Format(
    "candump", "candump -L (.log)", (".log",), _log,
    lambda head, ending: (LINE.search(text_begin(head)) or _PRINTED.search(head)) is not None, text=True,
)  # fmt: skip
