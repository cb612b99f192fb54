"""Logs of vendors become arrays block by block: nothing depends on the blocks, and few frames are Python objects."""

import io
import weakref

import numpy as np
import pytest

from can_logs import stored, together
from tierod.core.errors import InputError
from tierod.io.readers import vendor_can
from tierod.io.readers.frames import EXTENDED, Remembered
from tierod.io.readers.vendor_can import frames_of

can = pytest.importorskip("can")

WRITERS = {"blf": can.BLFWriter}


def message(k: int) -> can.Message:
    data = bytes(range(k % 9)) if k != 60 else bytes(range(32))
    return can.Message(
        timestamp=1.6e9 + 0.01 * k,
        arbitration_id=0x100 + k % 5 + (0x10000000 if k % 7 == 0 else 0),
        is_extended_id=k % 7 == 0,
        is_fd=k == 60,
        data=data,
        channel=k % 3,
    )


def log(kind: str, count: int = 75) -> bytes:
    """A log of frames of all lengths, both widths of identifiers and three buses."""
    file = io.BytesIO()
    writer = WRITERS[kind](file)
    for k in range(count):
        writer.on_message_received(message(k))
    file.close = lambda: None
    writer.stop()
    return file.getvalue()


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("block", [1, 10, 74, 75])
def test_the_frames_do_not_depend_on_the_blocks(tmp_path, monkeypatch, kind, block):
    data = log(kind)
    monkeypatch.setattr(vendor_can, "BLOCK", block)
    frames = together(frames_of(stored(tmp_path, data), kind))
    assert len(frames) == 75
    assert frames.time == pytest.approx(0.01 * np.arange(75), abs=2e-6)
    assert frames.notes == ()
    for at in range(75):
        sent = message(at)
        assert frames.identifier[at] == sent.arbitration_id | (EXTENDED if sent.is_extended_id else 0)
        assert frames.payload[at, : frames.length[at]].tobytes() == bytes(sent.data)
        assert not frames.payload[at, frames.length[at] :].any()
        assert frames.buses[frames.bus[at]] == str(sent.channel)


def test_damage_after_some_blocks_is_counted_from_the_first_frame(tmp_path, monkeypatch):
    def reader(content, kind):
        yield from map(message, range(25))
        raise ValueError("no such\nobject")

    monkeypatch.setattr(vendor_can, "BLOCK", 10)
    monkeypatch.setattr(vendor_can, "_reader", reader)
    frames = together(frames_of(stored(tmp_path, b""), "trc"))
    assert len(frames) == 25
    assert frames.notes == ("the log is damaged after 25 frames (no such object); the rest was left out",)


def test_only_the_frames_of_one_block_are_objects(tmp_path, monkeypatch):
    alive: set[int] = set()
    most = 0

    def reader(content, kind):
        nonlocal most
        for k in range(200):
            made = message(k)
            alive.add(k)
            weakref.finalize(made, alive.discard, k)
            most = max(most, len(alive))
            yield made

    monkeypatch.setattr(vendor_can, "BLOCK", 20)
    monkeypatch.setattr(vendor_can, "_reader", reader)
    assert len(together(frames_of(stored(tmp_path, b""), "trc"))) == 200
    assert most <= 43, "the block that grows, the one that became arrays, and the frame in hand"


def test_frames_with_impossible_identifiers_are_left_out_and_counted(tmp_path):
    identifiers = ["0123", 3 * "FFFF", "00000124", "FFFFFFFF", 20 * "F"]

    def log(names):
        rows = (f"{number:6d}) {1.0 + number:.1f}  Rx  {name}  2  01 02\n" for number, name in enumerate(names))
        return (";$FILEVERSION=1.1\n" + "".join(rows)).encode()

    frames = together(frames_of(stored(tmp_path, log(identifiers)), "trc"))
    assert len(frames) == 2
    assert frames.notes == ("frames with an identifier of more than 29 bits were left out: 3",)
    with pytest.raises(InputError, match="damaged .frames with an identifier of more than 29 bits"):
        together(frames_of(stored(tmp_path, log(identifiers[3:])), "trc"))


def test_frames_that_are_read_again_are_not_kept_in_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(vendor_can, "BLOCK", 10)
    content = stored(tmp_path, log("blf"))
    alive: list[weakref.ref] = []

    def read():
        for frames in frames_of(content, "blf"):
            alive.append(weakref.ref(frames.payload.base if frames.payload.base is not None else frames.payload))
            alive.append(weakref.ref(frames.time))
            yield frames

    remembered = Remembered(read)
    (first,) = remembered()
    whole = together(first)
    assert [each for each in alive[:-4] if each() is not None] == []
    (again,) = remembered()
    for column in ("time", "identifier", "bus", "payload", "length"):
        assert np.array_equal(getattr(together(list(remembered()[0])), column), getattr(whole, column))
    assert len(together(again)) == 75
