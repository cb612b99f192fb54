"""Databases of SAE J1939: parameter groups, and raw values by which a sender says that it has none to give."""

import numpy as np
import pytest

from tierod.io.readers import read
from tierod.io.readers.dbc import parameter_group

pytest.importorskip("cantools")

HEADER = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A B\n\n'

KIND = """
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ "ProtocolType" STRING ;
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
BA_DEF_DEF_ "ProtocolType" "";
BA_ "ProtocolType" "J1939";
BA_ "VFrameFormat" BO_ 2364540158 3;
"""


def decoded(tmp_path, signal: str, payloads: list[str], kind: str = KIND, names: str = "") -> list[float]:
    """The values of one signal of a message that another sender than that of the database sends."""
    number = 2364540158 if kind else 2364539904
    (tmp_path / "car.dbc").write_text(HEADER + f"BO_ {number} EEC1: 8 A\n SG_ S : {signal} B\n{kind}{names}")
    identifier = "18F00400" if kind else "0CF00400"
    lines = (f"({k}.0) can0 {identifier}#{payload}\n" for k, payload in enumerate(payloads))
    (tmp_path / "drive.log").write_text("".join(lines))
    return read(tmp_path / "drive.log", dbc=tmp_path / "car.dbc")["EEC1.S"].values.tolist()


def expected(values: list[float | None]):
    return pytest.approx([np.nan if value is None else value for value in values], nan_ok=True)


def test_a_parameter_group_matches_any_sender_and_priority(tmp_path):
    values = decoded(tmp_path, '24|16@1+ (0.125,0) [0|8031.875] "rpm"', ["000000401F", "000000FFFF", "00000000FE"])
    assert values == expected([1000.0, None, None])


def test_the_null_address_in_every_identifier_tells_j1939_without_its_attribute(tmp_path):
    assert decoded(tmp_path, '0|8@1+ (1,0) [0|0] ""', ["FA", "FF"], kind="\n") == expected([250, None])


def test_parameter_groups():
    assert parameter_group(0x18FEF100) == parameter_group(0x0CFEF1AA) == 0xFEF1
    assert parameter_group(0x18EA00F9) == parameter_group(0x18EAFFF9) == 0xEA00


@pytest.mark.parametrize(
    ("identifier", "group"),
    [(0x18EF2A01, 0xEF00), (0x18F02A01, 0xF02A), (0x18F00401, 0xF004), (0x19EF2A01, 0x1EF00), (0x19F02A01, 0x1F02A)],
)
def test_the_second_format_of_frames_begins_at_240(identifier, group):
    """J1939-21, section 5.1.2: PDU1 holds formats 0 to 239 and an address, PDU2 240 to 255 and a group extension."""
    assert parameter_group(identifier) == group


@pytest.mark.parametrize(
    ("length", "raw", "values"),
    [
        (1, [0, 1], [0, 1]),
        (2, [0, 1, 2, 3], [0, 1, None, None]),
        (3, [0, 5, 6, 7], [0, 5, 6, None]),
        (4, [0, 8, 13, 14, 15], [0, 8, 13, None, None]),
        (6, [0, 61, 62, 63], [0, 61, 62, None]),
        (8, [0, 250, 253, 254, 255], [0, 250, 253, None, None]),
    ],
)
def test_values_by_which_a_sender_says_that_it_has_none(tmp_path, length, raw, values):
    signal = f'0|{length}@1+ (1,0) [0|0] ""'
    payloads = [f"{number:02X}" for number in raw]
    assert decoded(tmp_path, signal, payloads) == expected(values)
    assert decoded(tmp_path, signal, payloads, kind="") == raw, "only J1939 agrees on such values"


def test_they_are_reported_by_the_raw_value_within_a_byte(tmp_path):
    assert decoded(tmp_path, '4|2@1+ (1,0) [0|0] ""', ["CF", "DF", "EF", "FF"]) == expected([0, 1, None, None])


def test_a_signed_parameter_cannot_say_it(tmp_path):
    assert decoded(tmp_path, '0|2@1- (1,0) [0|0] ""', ["00", "01", "02", "03"]) == [0, 1, -2, -1]


@pytest.mark.parametrize(
    ("names", "values"),
    [
        ('2 "torque control" 3 "speed and torque limit"', [0, 1, 2, 3]),
        ('1 "on" 0 "off"', [0, 1, None, None]),
        ('3 "Not available" 2 "Error"', [0, 1, None, None]),
        ('3 "Don\'t care/take no action" 2 "Reserved"', [0, 1, None, None]),
        ('3 "SNA" 2 "High beam"', [0, 1, 2, None]),
    ],
)
def test_a_state_that_the_database_names_is_kept(tmp_path, names, values):
    states = f"VAL_ 2364540158 S {names} ;\n"
    assert decoded(tmp_path, '0|2@1+ (1,0) [0|0] ""', ["00", "01", "02", "03"], names=states) == expected(values)
