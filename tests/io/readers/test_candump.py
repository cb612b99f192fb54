"""The array parser of candump text agrees with python-can, and survives broken lines."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from can_logs import together
from tierod.core.errors import InputError
from tierod.io.readers.candump import frames_of
from tierod.io.readers.content import whole_lines
from tierod.io.readers.frames import EXTENDED, Frames, messages


def read_frames(data: bytes, block: int = 1 << 20) -> Frames:
    blocks = (data[at : at + block] for at in range(0, len(data), block))
    return together(frames_of(whole_lines(blocks, "some.log")))


@st.composite
def lines(draw):
    wide = draw(st.booleans())
    identifier = draw(st.integers(0, 0x1FFFFFFF if wide else 0x7FF))
    payload = draw(st.binary(max_size=8))
    bus = draw(st.sampled_from(["can0", "can1", "vcan12"]))
    return identifier, wide, payload, bus


@settings(max_examples=100, deadline=None)
@given(st.lists(lines(), min_size=1, max_size=40), st.sampled_from(["\n", "\r\n"]), st.sampled_from(["", " R", " T"]))
def test_any_log_is_read_back(rows, ending, direction):
    texts = []
    for number, (identifier, wide, payload, bus) in enumerate(rows):
        name = f"{identifier:08X}" if wide else f"{identifier:03X}"
        texts.append(f"({1600000000 + number}.{number:06d}) {bus} {name}#{payload.hex().upper()}{direction}")
    frames = read_frames(ending.join(texts).encode())
    assert len(frames) == len(rows)
    assert frames.notes == ()
    for at, (identifier, wide, payload, bus) in enumerate(rows):
        assert int(frames.identifier[at]) == identifier | (EXTENDED if wide else 0)
        assert frames.payload[at, : frames.length[at]].tobytes() == payload
        assert frames.buses[frames.bus[at]] == bus
        assert frames.time[at] == pytest.approx(at * 1.000001, abs=1e-9)
    assert frames.origin == 1600000000.0


def test_a_fraction_counts_by_its_digits():
    frames = read_frames(b"(10.5) can0 123#01\n(10.750) can0 123#02\n(11.000000001) can0 123#03\n")
    np.testing.assert_allclose(np.diff(frames.time), [0.25, 0.250000001], atol=1e-10)


@pytest.mark.parametrize("block", [1, 60, 200])
def test_the_frames_do_not_depend_on_how_much_is_parsed_at_once(block):
    rows = [(k, f"can{k % 3}", f"{0x100 + k % 5:03X}", "AB" * (k % 9)) for k in range(50)]
    text = (
        "".join(f"({k}.25) {bus} {name}#{data}\n" for k, bus, name, data in rows) + "garbage\n(60.5) can0 1FFFFFFF#01"
    )
    whole = read_frames(text.encode())
    again = read_frames(text.encode(), block)
    assert again.buses == whole.buses
    assert again.notes == whole.notes == ("1 of 52 lines of the log are broken and were left out",)
    for column in ("time", "identifier", "bus", "payload", "length"):
        assert np.array_equal(getattr(again, column), getattr(whole, column))


def test_three_digits_beyond_eleven_bits_are_another_message():
    frames = read_frames(b"(1.0) can0 F23#01\n(1.1) can1 723#02\n(1.2) can0 F23#03\n(1.3) can1 723#04\n")
    assert [(hex(found.identifier), found.bus, found.rows.tolist()) for found in messages(frames)] == [
        ("0xf23", 0, [0, 2]),
        ("0x723", 1, [1, 3]),
    ]


def test_broken_lines_are_counted_and_left_out():
    good = [f"({number}.5) can0 123#0{number}" for number in range(1, 6)]
    bad = ["", "garbage", "(7.5) can0 123#0G", "(8.5) can0 123#012", "(x.5) can0 123#01", "(9.5) can0 1"]
    frames = read_frames("\n".join([*good, *bad, "  can0  123   [1]  07"]).encode())
    assert frames.payload[:, 0].tolist() == [1, 2, 3, 4, 5]
    assert frames.notes == ("6 of 11 lines of the log are broken and were left out",)


def test_remote_and_error_frames_are_no_damage():
    frames = read_frames(b"(1.0) can0 123#01\n(1.1) can0 123#R\n(1.2) can0 20000004#0000000000000000\n")
    assert len(frames) == 1
    assert frames.notes == ()


def test_flexible_data_rate():
    frames = read_frames(b"(1.0) can0 123##1" + b"AB" * 64 + b"\n(1.1) can0 123#01\n")
    assert frames.length.tolist() == [64, 1]
    assert (frames.payload[0] == 0xAB).all()
    assert frames.payload[1].tolist() == [1] + [0] * 63


@pytest.mark.parametrize("text", [b"", b"\n\n", b"  can0  123   [2]  01 02\n", b"(1.0) can0 123\n"])
def test_no_frame_at_all(text):
    with pytest.raises(InputError, match="candump -L"):
        read_frames(text)


def test_microseconds_survive():
    frames = read_frames(b"(1533198887.000013) can0 123#01\n(1533198887.000026) can0 123#01\n")
    assert frames.time[1] == pytest.approx(13e-6, abs=1e-12)
    assert np.array_equal(frames.time[:1], [0.0])


@pytest.mark.parametrize("line", [b"(" + 350 * b"9" + b".5) can0 123#01", b"(1." + 350 * b"5" + b") can0 123#01"])
def test_a_time_of_hundreds_of_digits_is_none(line):
    frames = read_frames(b"(1.5) can0 123#01\n" + line + b"\n")
    assert len(frames) == 1
    assert frames.notes == ("1 of 2 lines of the log are broken and were left out",)


def test_a_log_of_more_buses_than_there_can_be_is_damaged():
    with pytest.raises(InputError, match="more than 64 buses"):
        read_frames(b"".join(b"(1.5) can%05d 123#01\n" % number for number in range(70_000)))


@pytest.mark.parametrize("option", ["ta", "tz", "td", "tA"])
def test_a_log_as_candump_prints_it(option):
    stamps = 0.02 * np.arange(200)
    calendar = [f"2024-05-13 09:05:{each:09.6f}" for each in stamps]
    shown = {"ta": 1.7e9 + stamps, "tz": stamps, "td": np.diff(stamps, prepend=0.0), "tA": calendar}[option]
    lines = [
        f" ({each if option == 'tA' else f'{each:010.6f}'})  can0  120   [2]  {k % 256:02X} 0A\n"
        for k, each in enumerate(shown)
    ]
    frames = read_frames("".join(lines).encode(), 700)
    assert frames.time == pytest.approx(stamps, abs=1e-6)
    assert frames.payload[5, :2].tolist() == [5, 10]


def test_a_printed_log_without_time_is_refused():
    with pytest.raises(InputError, match="no time stamps; record it with"):
        list(frames_of([b"  can0  120   [2]  00 0A\n"]))
