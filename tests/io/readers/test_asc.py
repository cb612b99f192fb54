"""ASC logs: time stamps of every kind, both bases, frames beside events; nothing is lost without a count."""

import io

import numpy as np
import pytest

from can_logs import stored
from tierod.core.errors import InputError
from tierod.io.readers import read
from tierod.io.readers.frames import EXTENDED
from tierod.io.readers.opening import frames_in

can = pytest.importorskip("can")

DBC = """VERSION ""
BU_: X
BO_ 288 STEER: 2 X
 SG_ SteeringWheelAngle : 7|16@0- (0.1,0) [-800|800] "deg" X
"""

DATE = "Mon Dec 6 11:21:13.000 am 2021"
BEGIN = 1638789673.0


def header(stamps: str, base: str = "hex", events: str = "no internal events logged\n") -> str:
    return f"date {DATE}\nbase {base}  timestamps {stamps}\n{events}Begin Triggerblock {DATE}\n"


def weave(stamps) -> str:
    """Lines of an angle from -100 to 100 degrees, with these time stamps."""
    raw = np.linspace(-1000, 1000, len(stamps)).astype(int)
    data = [int(each).to_bytes(2, "big", signed=True).hex(" ").upper() for each in raw]
    return "".join(f"{t:11.6f} 1  120             Rx   d 2 {each}\n" for t, each in zip(stamps, data, strict=True))


def angle(tmp_path, text: str):
    (tmp_path / "car.dbc").write_text(DBC)
    (tmp_path / "drive.asc").write_text(text, encoding="latin-1")
    found = read(tmp_path / "drive.asc", dbc=tmp_path / "car.dbc")
    return found, found["steering_wheel_angle"]


@pytest.mark.parametrize(
    ("stamps", "start"),
    [
        (("absolute", 0.02 * np.arange(500)), 0.0),
        (("relative", [0.0, *[0.02] * 499]), 0.0),
        (("absolute", -5.0 + 0.02 * np.arange(500)), -5.0),
        (("relative", [-5.0, *[0.02] * 499]), -5.0),
    ],
)
def test_stamps_count_from_the_trigger_or_from_the_event_before(tmp_path, stamps, start):
    kind, times = stamps
    found, channel = angle(tmp_path, header(kind) + weave(times) + "End TriggerBlock\n")
    assert channel.time == pytest.approx(0.02 * np.arange(500), abs=1e-6)
    assert np.degrees(channel.values[[0, -1]]) == pytest.approx([-100.0, 100.0])
    assert found.metadata["origin"] == pytest.approx(BEGIN + start)
    assert not found.warnings


def test_every_event_advances_a_relative_time(tmp_path):
    lines = weave([0.02] * 10).splitlines(keepends=True)
    lines.insert(3, "   0.500000 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%\n")
    lines.insert(6, "   0.250000 CAN 1 Status:chip status error active\n")
    lines.insert(8, "   0.125000 1  ErrorFrame\n// 9.0 a comment\n")
    found, channel = angle(tmp_path, header("relative") + "".join(lines))
    steps = np.full(9, 0.02)
    steps[[2, 4, 5]] += (0.5, 0.25, 0.125)
    assert np.diff(channel.time) == pytest.approx(steps, abs=1e-6)
    assert not found.warnings


@pytest.mark.parametrize(
    ("stamps", "second"),
    [
        ("absolute", 60.0 + 0.02 * np.arange(100)),
        ("absolute", 0.02 * np.arange(100)),
        ("relative", [0.0] + [0.02] * 99),
    ],
)
def test_a_second_trigger_counts_from_its_own_date_or_goes_on(tmp_path, stamps, second):
    first = 0.02 * np.arange(100) if stamps == "absolute" else [0.0] + [0.02] * 99
    later = DATE.replace("11:21:13", "11:22:13")
    text = header(stamps) + weave(first) + f"End TriggerBlock\nBegin Triggerblock {later}\n" + weave(second)
    _, channel = angle(tmp_path, text)
    expected = np.concatenate((0.02 * np.arange(100), 60.0 + 0.02 * np.arange(100)))
    assert channel.time == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("events", ["", "internal events logged\n// version 9.0.0\n", "no internal events logged\n"])
def test_no_frame_is_taken_for_a_header(tmp_path, events):
    text = header("absolute", events=events).replace(f"Begin Triggerblock {DATE}\n", "")
    _, channel = angle(tmp_path, text + weave(0.02 * np.arange(50)))
    assert len(channel.time) == 50


def test_lines_that_cannot_be_read_are_counted_and_cost_no_other(tmp_path):
    lines = weave(0.02 * np.arange(50)).splitlines(keepends=True)
    lines[7] = "   0.140000 1  EngineData      Rx   d 2 00 01\n"
    lines[20] = "   0.400000 1  120             Rx   d 2 0G 01\n"
    lines[30] = "   0.600000 1  120     \xe4\x00\x00garbage\n"
    lines[49] = lines[49][:-4]
    found, channel = angle(tmp_path, header("absolute") + "".join(lines))
    assert len(channel.time) == 46
    assert "lines that hold no CAN frame were left out: 4" in found.warnings


def test_frames_with_impossible_identifiers_are_left_out_and_counted(tmp_path):
    names = ["120", 3 * "FFFF" + "x", "00000120", "FFFFFFFFx", 20 * "F" + "x"]
    rows = [f"   {k:.6f} 1  {name}  Rx   d 2 00 01\n" for k, name in enumerate(names)]
    found, channel = angle(tmp_path, header("absolute") + "".join(rows))
    assert len(channel.time) == 2
    assert "frames with an identifier of more than 29 bits were left out: 3" in found.warnings
    with pytest.raises(InputError, match="holds no frame with data .frames with an identifier of more than 29 bits"):
        angle(tmp_path, header("absolute") + rows[1])


def test_a_log_of_more_buses_than_there_can_be_is_damaged(tmp_path):
    rows = "".join(f" {k}.5 {k + 1}  123  Rx   d 2 01 02\n" for k in range(70))
    with pytest.raises(InputError, match="more than 64 buses"):
        angle(tmp_path, header("absolute") + rows)


def frames_by(path):
    (lane,) = frames_in(path).lanes()
    found = []
    for part in lane:
        names = [part.buses[bus] for bus in part.bus]
        data = [part.payload[at, :length].tobytes() for at, length in enumerate(part.length)]
        found += zip((part.origin + part.time).tolist(), part.identifier.tolist(), names, data, strict=True)
    return found


def same_as_python_can(path):
    """Compare the frames with those of python-can, whose calendar time is local."""
    reader = can.ASCReader(str(path), relative_timestamp=False)
    wanted = [each for each in reader if not (each.is_error_frame or each.is_remote_frame)]
    found = frames_by(path)
    assert len(found) == len(wanted) > 0
    for (time, identifier, bus, data), message in zip(found, wanted, strict=True):
        assert time - found[0][0] == pytest.approx(message.timestamp - wanted[0].timestamp, abs=2e-6)
        assert identifier == message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
        assert (bus, data) == (str(message.channel), bytes(message.data))


def test_frames_of_all_lengths_are_those_of_python_can(tmp_path):
    file = io.StringIO()
    writer = can.ASCWriter(file)
    for k in range(75):
        data = bytes(range(k % 9)) if k % 20 else bytes(range(32))
        wide = k % 7 == 0
        writer.on_message_received(can.Message(
            timestamp=1.6e9 + 0.01 * k, arbitration_id=0x100 + k % 5 + 0x10000000 * wide, is_extended_id=wide,
            is_fd=k % 20 == 0, data=data, channel=k % 3, is_error_frame=k == 33, is_remote_frame=k == 43,
        ))  # fmt: skip
    file.close = lambda: None
    writer.stop()
    same_as_python_can(stored(tmp_path, file.getvalue().encode(), "drive.asc").path)


HEX = """   0.000000 Start of measurement
   2.501000 1 ErrorFrame ECC: 10100010
   2.520002 3 200 Tx r Length = 1704000 BitCount = 145 ID = 88888888x
   2.550002 3 200 Tx d 0
   3.098426 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount = 141 ID = 418119424x
   3.297743 1  J1939TP FEE3p        6    0  0   -   Rx   d 9 A0 0F A6 60 3B D1 40 1F DE
   3.300000 1  3FF             Tx   d D 55 AA 01 02 03 04 05 06  Length = 232016 BitCount = 119 ID = 1023
   3.400000 CANFD   5 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe c7 31ca Arb. 556 44 0 0 f 64 00
   3.500000 CANFD   2 Tx        1C4D80A7x                     0 1 8  8 12 c2 03 04 05 06 07 08   102203  133   303000
   3.600000 CANFD   3 Rx        30a  Generic_Name_12          1 1 9 12 01 02 03 04 05 06 07 08 09 0a 0b 0c   102203
   3.700000 CANFD   3 Tx        50005x                        0 1 5 0 140000 73 200050 7a60
"""

DECIMAL = """   0.100000 1  418119424x      Rx   d 8 1 160 15 166 96 59 209 64
   0.200000 2  1023            TxRq d 3 255 0 7
"""


@pytest.mark.parametrize(("base", "rows"), [("hex", HEX), ("dec", DECIMAL)])
@pytest.mark.parametrize("date", [DATE, "Mon Dez 6 11:21:13.250 2021", "Mon Dec 6 11:21:13 2021"])
def test_lines_of_every_kind_are_those_of_python_can(tmp_path, base, rows, date):
    text = header("absolute", base, "internal events logged\n// version 9.0.0\n").replace(DATE, date)
    same_as_python_can(stored(tmp_path, (text + rows + "End TriggerBlock\n").encode(), "drive.asc").path)


def test_a_date_in_another_language_costs_the_calendar_alone(tmp_path):
    found, channel = angle(tmp_path, header("absolute").replace("Mon Dec", "lun d\xe9c.") + weave(0.02 * np.arange(50)))
    assert len(channel.time) == 50
    assert found.metadata["origin"] == 0.0
