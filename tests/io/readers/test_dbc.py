"""Decoding with databases agrees with cantools, message by message, and survives what a database or a frame lacks."""

import math

import numpy as np
import pytest
from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from can_logs import log_of
from tierod.core.errors import InputError, MissingExtra
from tierod.io.readers import open_chunks, read
from tierod.io.readers.content import Allowance
from tierod.io.readers.dbc import bus_source, load_databases
from tierod.io.readers.frames import EXTENDED, Frames, heard
from tierod.io.readers.payloads import Payloads, span
from tierod.io.readers.slices import slices

cantools = pytest.importorskip("cantools")

HEADER = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A B\n\n'


def frames_of(
    payloads: list[bytes], identifier: int = 0x100, bus: int = 0, buses: tuple[str, ...] = ("can0",)
) -> Frames:
    width = max(8, max(map(len, payloads)))
    data = np.frombuffer(b"".join(payload.ljust(width, b"\0") for payload in payloads), np.uint8).reshape(-1, width)
    count = len(payloads)
    length = np.array([len(payload) for payload in payloads])
    time = 0.01 * np.arange(count)
    return Frames(time, np.full(count, identifier, np.uint32), np.full(count, bus, np.uint16), data, length, buses)


def decoded(database: str, frames: Frames, tmp_path) -> dict:
    path = tmp_path / "some.dbc"
    path.write_text(HEADER + database)
    log = log_of(frames)
    source = bus_source(log, heard(log), load_databases([path]), {})
    lanes = source.lanes([column.name for column in source.columns])
    (whole,) = slices(lanes, math.inf, Allowance(path, 0))
    return {channel.name: channel for channel in whole.channels}


@st.composite
def signals(draw):
    """One signal of a DBC that fits into a frame of eight bytes, or of 64 of CAN FD."""
    size = draw(st.sampled_from([8, 8, 8, 64]))
    real = draw(st.booleans()) and draw(st.booleans())
    length = draw(st.sampled_from([32, 64])) if real else draw(st.integers(1, 64))
    big = draw(st.booleans())
    begin = draw(st.integers(0, 8 * size - length))
    start = 8 * (begin // 8) + 7 - begin % 8 if big else begin
    signed = True if real else draw(st.booleans())
    factor = draw(st.sampled_from([1.0, 0.1, 0.244, -2.0, 1e-3]))
    offset = draw(st.sampled_from([0.0, -125.0, 3.5]))
    return size, start, length, big, signed, real, factor, offset


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(signals(), st.data())
def test_any_signal_agrees_with_cantools(tmp_path, made, data):
    size, start, length, big, signed, real, factor, offset = made
    text = f"BO_ 256 M: {size} A\n SG_ S : {start}|{length}@{0 if big else 1}{'-' if signed else '+'} "
    text += f'({factor},{offset}) [0|0] "" B\n'
    text += f"\nSIG_VALTYPE_ 256 S : {1 if length == 32 else 2};\n" if real else ""
    payloads = data.draw(st.lists(st.binary(min_size=size, max_size=size), min_size=1, max_size=5))
    ours = decoded(text, frames_of(payloads), tmp_path)["M.S"].values
    peer = cantools.database.load_string(HEADER + text)
    theirs = [float(peer.decode_message(256, payload)["S"]) for payload in payloads]
    np.testing.assert_allclose(ours, np.array(theirs), rtol=1e-12, atol=1e-12 * abs(factor) + 1e-12)


SIMPLE = 'BO_ 256 M: 8 A\n SG_ HEAD : 0|8@1+ (1,0) [0|0] "m" B\n SG_ TAIL : 48|16@1- (0.5,1) [0|0] "deg" B\n'


def test_a_short_frame_gives_missing_values_not_garbage(tmp_path):
    ours = decoded(SIMPLE, frames_of([bytes(8), b"\x07\x01"]), tmp_path)
    assert ours["M.HEAD"].values.tolist() == [0.0, 7.0]
    assert ours["M.TAIL"].values[0] == 1.0
    assert np.isnan(ours["M.TAIL"].values[1])


MULTIPLEXED = """BO_ 256 M: 8 A
 SG_ WHICH M : 0|4@1+ (1,0) [0|0] "" B
 SG_ ONE m1 : 8|16@1+ (1,0) [0|0] "" B
 SG_ TWO m2 : 8|16@1- (0.1,0) [0|0] "" B
 SG_ ALWAYS : 32|8@1+ (1,0) [0|0] "" B
"""

EXTENDED_MULTIPLEXED = """BO_ 256 M: 8 A
 SG_ WHICH M : 0|4@1+ (1,0) [0|0] "" B
 SG_ INNER m3M : 4|4@1+ (1,0) [0|0] "" B
 SG_ DEEP m2 : 8|8@1+ (1,0) [0|0] "" B
 SG_ RANGE m5 : 8|8@1+ (1,0) [0|0] "" B

SG_MUL_VAL_ 256 INNER WHICH 3-3;
SG_MUL_VAL_ 256 DEEP INNER 2-2;
SG_MUL_VAL_ 256 RANGE WHICH 5-7;
"""


@pytest.mark.parametrize("database", [MULTIPLEXED, EXTENDED_MULTIPLEXED])
def test_multiplexed_signals_agree_with_cantools(database, tmp_path):
    payloads = [bytes([first, 10 * number % 256, number, 0, 9, 0, 0, 0]) for number, first in enumerate(range(256))]
    peer = cantools.database.load_string(HEADER + database)
    frames = frames_of(payloads)
    ours = decoded(database, frames, tmp_path)
    theirs: dict[str, list] = {}
    for time, payload in zip(frames.time, payloads, strict=True):
        try:
            values = peer.decode_message(256, payload, decode_choices=False)
        except cantools.database.errors.DecodeError:
            continue
        for name, value in values.items():
            theirs.setdefault(f"M.{name}", []).append((time, float(value)))
    assert set(theirs) == set(ours)
    for name, rows in theirs.items():
        if name not in ("M.WHICH", "M.INNER", "M.ALWAYS"):
            assert list(zip(ours[name].time, ours[name].values, strict=True)) == rows


@pytest.mark.parametrize(
    "protocol", ["", 'BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","J1939PG";\nBA_ "VFrameFormat" BO_ 256 1;\n']
)
def test_a_signal_that_is_no_number_has_no_values_and_its_neighbours_have(tmp_path, protocol):
    database = 'BO_ 256 M: 8 A\n SG_ Key : 0|512@1+ (1,0) [0|0] "" B\n SG_ Speed : 8|8@1+ (1,0) [0|0] "" B\n' + protocol
    found = decoded(database, frames_of([bytes([0, 7, 0, 0, 0, 0, 0, 0])]), tmp_path)
    assert np.isnan(found["M.Key"].values).all()
    assert list(found["M.Speed"].values) == [7.0]


def test_choices_are_numbers(tmp_path):
    text = SIMPLE + '\nVAL_ 256 HEAD 1 "on" 0 "off";\n'
    assert decoded(text, frames_of([b"\x01" + bytes(7)]), tmp_path)["M.HEAD"].values.tolist() == [1.0]


@pytest.mark.parametrize(
    "name", ["SNA", "Init", "Error Indicator", "Signal not available", "Invalid", "Fehler", "nicht verfügbar", "Défaut"]
)
def test_numbers_that_the_value_table_names_as_none_are_missing(tmp_path, name):
    signal = 'BO_ 256 M: 8 A\n SG_ S : 0|16@1+ (0.1,-1000) [0|0] "deg" B\n SG_ G : 16|3@1+ (1,0) [0|0] "" B\n'
    table = f'VAL_ 256 S 65535 "{name}" 10000 "zero (valid)" ;\nVAL_ 256 G 7 "{name}" 0 "P" 1 "R" 2 "N" 3 "D" ;\n'
    frames = frames_of([bytes([255, 255, 7]), bytes([16, 39, 3]), bytes([0, 0, 0])])
    found = decoded(signal + table, frames, tmp_path)
    assert found["M.S"].values == pytest.approx([math.nan, 0.0, -1000.0], nan_ok=True)
    assert found["M.G"].values.tolist() == [7.0, 3.0, 0.0], "a list of states keeps its numbers"


def test_missing_numbers_of_a_value_table_are_remarked_once(tmp_path):
    database = 'BO_ 256 M: 8 A\n SG_ S : 0|16@1+ (1,0) [0|0] "deg" B\n\nVAL_ 256 S 65535 "SNA" ;\n'
    (tmp_path / "some.dbc").write_text(HEADER + database)
    lines = [f"({1.7e9 + k / 100:.2f}) can0 100#{'FFFF' if k < 7 else '0100'}000000000000\n" for k in range(200)]
    (tmp_path / "bus.log").write_text("".join(lines))
    recording = read(tmp_path / "bus.log", dbc=str(tmp_path / "some.dbc"))
    (said,) = [each for each in recording.warnings if "names as not available" in each]
    assert said.endswith("missing: 7 of M.S")


def test_the_same_message_on_two_buses_is_distinguished(tmp_path):
    one, two = frames_of([bytes(8)]), frames_of([b"\x05" + bytes(7)])
    both = Frames(
        np.array([0.0, 0.1]),
        np.concatenate((one.identifier, two.identifier)),
        np.array([0, 1], np.uint16),
        np.concatenate((one.payload, two.payload)),
        np.array([8, 8]),
        ("can0", "can1"),
    )
    ours = decoded(SIMPLE, both, tmp_path)
    assert ours["M.HEAD"].values.tolist() == [0.0]
    assert ours["can1:0x100:M.HEAD"].values.tolist() == [5.0]
    assert ours["M.HEAD"].source == "M.HEAD (0x100 on can0)"


def test_a_standard_identifier_is_not_an_extended_one(tmp_path):
    with pytest.raises(InputError, match="matches no frame"):
        decoded(SIMPLE, frames_of([bytes(8)], 0x100 | EXTENDED), tmp_path)


def test_a_database_of_another_car_names_both_sides(tmp_path):
    with pytest.raises(InputError, match="the log holds 0x321, the DBC 0x100; give the DBC of this vehicle"):
        decoded(SIMPLE, frames_of([bytes(8)], 0x321), tmp_path)


def test_no_database(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load_databases([tmp_path / "absent.dbc"])
    broken = tmp_path / "broken.dbc"
    broken.write_text("this is no database")
    with pytest.raises(InputError, match="is not a CAN database"):
        load_databases([broken])
    empty = tmp_path / "empty.dbc"
    empty.write_text(HEADER)
    with pytest.raises(InputError, match="describes no CAN message"):
        load_databases([empty])


def test_without_cantools(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "cantools", None)
    with pytest.raises(MissingExtra, match=r"pip install 'tierod\[can\]'"):
        load_databases([tmp_path / "some.dbc"])


@pytest.mark.parametrize(("unit", "name"), [("rpm", "Engine.Speed"), ("", "Engine.Speed"), ("km/h", "vehicle_speed")])
def test_a_signal_with_a_general_name_needs_a_unit_that_fits(tmp_path, unit, name):
    (tmp_path / "car.dbc").write_text(HEADER + f'BO_ 256 Engine: 8 A\n SG_ Speed : 0|8@1+ (1,0) [0|0] "{unit}" B\n')
    (tmp_path / "drive.log").write_text("".join(f"(0.{k}) can0 100#0{k}00000000000000\n" for k in range(9)))
    assert read(tmp_path / "drive.log", dbc=tmp_path / "car.dbc").names == (name,)


MAP = '[signals.yaw_rate]\nsource = "M.Turn"\nsign = -1\n[signals.vehicle_speed]\nsource = "Other.Speed"\n'


@pytest.fixture
def bus(tmp_path):
    """A log of one message, its database, and a map beside that knows of a message which the log lacks."""
    message = 'BO_ 256 M: 8 A\n SG_ Turn : 0|8@1- (1,0) [0|0] "deg/s" B\n'
    other = 'BO_ 257 Other: 8 A\n SG_ Speed : 0|8@1- (1,0) [0|0] "m/s" B\n'
    (tmp_path / "car.dbc").write_text(HEADER + message + "\n" + other)
    (tmp_path / "car.channels.toml").write_text(MAP)
    lines = (f"({0.01 * k:.6f}) can0 100#{k:02X}00000000000000\n" for k in range(100))
    (tmp_path / "drive.log").write_text("".join(lines))
    return tmp_path


def test_the_map_beside_the_database_counts(bus):
    for recording in (
        read(bus / "drive.log", dbc=bus / "car.dbc"),
        next(iter(open_chunks(bus / "drive.log", dbc=[bus / "car.dbc"]))),
    ):
        assert recording["yaw_rate"].values[90] == pytest.approx(np.radians(-90.0))
        assert recording.metadata["channel_map"] == str(bus / "car.channels.toml")
        assert "vehicle_speed" not in recording


def test_a_map_that_is_given_replaces_the_one_beside(bus):
    (bus / "mine.toml").write_text('[signals.yaw_rate]\nsource = "M.Turn"\n')
    recording = read(bus / "drive.log", dbc=bus / "car.dbc", channel_map=bus / "mine.toml")
    assert recording["yaw_rate"].values[90] == pytest.approx(np.radians(90.0))
    assert recording.metadata["channel_map"] == str(bus / "mine.toml")


def test_a_message_that_never_came_is_reported_and_keeps_nothing_else_from_being_read(bus):
    needed = '[signals.yaw_rate]\nsource = "M.Turn"\n[signals.vehicle_speed]\nsource = "Other.Speed"\n'
    (bus / "mine.toml").write_text(needed)
    recording = read(bus / "drive.log", dbc=bus / "car.dbc", channel_map=bus / "mine.toml")
    assert len(recording["yaw_rate"].time) == 100
    assert "vehicle_speed is not in the recording: Other.Speed was never received on the bus" in recording.warnings
    turn = read(bus / "drive.log", dbc=bus / "car.dbc", channel_map=bus / "mine.toml", names=["yaw_rate"])
    assert turn.warnings == (), "the other was not asked for"


def test_a_log_without_any_wanted_message_says_so(bus):
    (bus / "mine.toml").write_text('[signals.vehicle_speed]\nsource = "Other.Speed"\n')
    with pytest.raises(InputError, match="no message with a wanted signal was received on the bus .Other.Speed"):
        read(bus / "drive.log", dbc=bus / "car.dbc", channel_map=bus / "mine.toml", names=["vehicle_speed"])


def test_a_source_that_the_database_lacks_stays_a_slip_of_the_map(bus):
    (bus / "mine.toml").write_text('[signals.vehicle_speed]\nsource = "Other.Sped"\n')
    with pytest.raises(InputError, match="'Other.Sped' is not in the file"):
        read(bus / "drive.log", dbc=bus / "car.dbc", channel_map=bus / "mine.toml")


def test_a_broken_map_beside_is_named(bus):
    (bus / "car.channels.toml").write_text("[signals.yaw_rat]\nsource = 'M.Turn'\n")
    with pytest.raises(InputError, match="car.channels.toml.*did you mean 'yaw_rate'"):
        read(bus / "drive.log", dbc=bus / "car.dbc")


def test_names_that_come_twice_are_no_message_to_the_user(tmp_path, caplog):
    path = tmp_path / "twice.dbc"
    path.write_text(HEADER + "".join(f'BO_ {number} M: 8 A\n SG_ x : 0|8@1+ (1,0) [0|0] "" B\n\n' for number in (1, 2)))
    assert len(load_databases([path])) == 2
    assert not caplog.records


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_units_beyond_ascii_are_read_in_either_encoding(tmp_path, encoding):
    text = 'VERSION ""\nBU_: X\nBO_ 288 M: 8 X\n SG_ YawRate : 0|16@1- (0.01,0) [0|0] "\xb0/s" X\n'
    (tmp_path / "car.dbc").write_bytes(text.encode(encoding))
    (message,) = load_databases([tmp_path / "car.dbc"])
    assert message.signals[0].unit == "\xb0/s"


FRAMES = np.arange(24, dtype=np.uint8).reshape(3, 8)


@pytest.mark.parametrize("big_endian", [False, True])
@pytest.mark.parametrize(
    ("start", "length", "real"),
    [(0, 0, False), (0, -1, False), (-1, 10, False), (33, 65, False), (33, 512, False), (0, 63, True), (0, 8, True)],
)
def test_no_number_of_a_frame_has_no_value(start, length, real, big_endian):
    values = Payloads(FRAMES).raw(start, length, big_endian, real=real)
    assert values.shape == (3,)
    assert np.isnan(values).all()


def test_a_signal_beyond_the_frame_is_zero_until_its_length_is_asked():
    assert not Payloads(FRAMES).raw(4096, 15, False).any()


@pytest.mark.parametrize("order", ["little_endian", "big_endian"])
@pytest.mark.parametrize("length", [12, 57, 60, 63, 64])
def test_signals_across_nine_bytes_are_what_cantools_decodes(order, length):
    random = np.random.default_rng(length)
    frames = random.integers(0, 256, (4, 16), dtype=np.uint8)
    big = order == "big_endian"
    for start in range(40):
        first, last = span(start, length, big)
        assert last - first == length
        for signed in (False, True):
            signal = Signal(
                "s", start, length, byte_order=order, conversion=BaseConversion.factory(1, 0), is_signed=signed
            )
            message = Message(1, "m", 16, [signal])
            found = Payloads(frames).raw(start, length, big, signed=signed)
            assert found.tolist() == [message.decode(row.tobytes())["s"] for row in frames], (start, signed)


@pytest.mark.parametrize(
    ("odd", "said"),
    [
        ('BO_ 1275 2017_A: 8 A\n SG_ A : 0|8@1+ (1,0) [0|0] "" B\nVAL_ 1275 A 1 "on" ;\n', "line 12: message '2017_A'"),
        ('BO_ 300 M: 8 A\n SG_ 0_COUNTER : 0|8@1+ (1,0) [0|0] "" B\n', "line 13: signal '0_COUNTER'"),
        ('BO_ 1075054137 FAR: 8 A\n SG_ A : 0|8@1+ (1,0) [0|0] "" B\n', "line 12: message 'FAR'"),
        ('BA_DEF_ BO_ "Receivable" BOOL False True;\n', "line 12: BA_DEF_"),
        ('BO_ 274878464 DOOR: 8 A\n SG_ A : 0|8@1+ (1,0) [0|0] "" B\nCM_ BO_ 274878464 "door";\n', ""),
    ],
)
def test_one_odd_entry_is_left_out_and_named(tmp_path, odd, said):
    (tmp_path / "some.dbc").write_text(HEADER + 'BO_ 256 W: 2 A\n SG_ S : 0|8@1+ (1,0) [0|0] "deg" B\n\n' + odd)
    database = load_databases([tmp_path / "some.dbc"])
    assert database[0].signals[0].name == "S"
    assert said in "".join(database.notes)
    assert len(database.notes) == bool(said)
    assert [message.is_extended_frame for message in database if message.name == "DOOR"] == [True] * ("DOOR" in odd)
