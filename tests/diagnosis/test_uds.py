"""Answers to a tester, decoded by udsoncan; the switch to substitutes."""

from __future__ import annotations

import math
import struct

import pytest
from udsoncan import DidCodec, Response
from udsoncan.services import ReadDTCInformation

from diagnosis.memories import code, drive, table
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.uds import answer


class SinglePrecision(DidCodec):
    def encode(self, value):
        return struct.pack(">f", value)

    def decode(self, payload):
        return struct.unpack(">f", payload)[0]

    def __len__(self):
        return 4


@pytest.fixture
def memory():
    memory = FaultMemory(table(a=code(1, lamp=True), b=code(2), c=code(3)))
    drive(memory, {"a": (-1.0, 5.0, 1.0), "b": -1.0})
    return memory


def ask(memory, request):
    response = Response.from_payload(answer(memory, request))
    assert response.positive, response
    return ReadDTCInformation.interpret_response(
        response,
        subfunction=request[1],
        extended_data_size={0x5A0162: 1},
        dtc_snapshot_did_size=2,
        didconfig={0xD001: SinglePrecision(), 0xD006: SinglePrecision()},
    ).service_data


def test_codes_by_status(memory):
    (found,) = ask(memory, bytes([0x19, 0x02, 0x08])).dtcs
    assert found.id == 0x5A0162
    assert found.status.get_byte_as_int() == int(memory.entries["a"].status)
    assert found.status.confirmed
    assert found.status.warning_indicator_requested
    assert found.status.test_failed


def test_the_freeze_frame(memory):
    (found,) = ask(memory, bytes([0x19, 0x04, 0x5A, 0x01, 0x62, 0x01])).dtcs
    snapshots = {each.did: each.data for each in found.snapshots}
    assert snapshots == pytest.approx({0xD001: 15.0, 0xD006: math.sin(5.0)}, rel=1e-6)
    (both,) = ask(memory, bytes([0x19, 0x04, 0x5A, 0x01, 0x62, 0xFF])).dtcs
    assert sorted({each.record_number for each in both.snapshots}) == [1, 2]


@pytest.mark.parametrize(("record", "value"), [(1, 1), (2, 127), (3, 1), (4, 0)])
def test_extended_data(memory, record, value):
    (found,) = ask(memory, bytes([0x19, 0x06, 0x5A, 0x01, 0x62, record])).dtcs
    (data,) = found.extended_data
    assert (data.record_number, data.raw_data) == (record, bytes([value]))


@pytest.mark.parametrize(
    ("request_", "refused"),
    [
        ("", "7F 00 11"),
        ("22 F1 90", "7F 22 11"),
        ("19", "7F 19 13"),
        ("19 02", "7F 19 13"),
        ("19 55 01", "7F 19 12"),
        ("19 04 00 00 00 01", "7F 19 31"),
        ("19 04 5A 01 62 07", "7F 19 31"),
        ("19 06 5A 01 62 09", "7F 19 31"),
        ("19 02 FF FF", "7F 19 13"),
        ("19 04 5A 01 62", "7F 19 13"),
        ("19 0A 00", "7F 19 13"),
        ("14 FF FF", "7F 14 13"),
        ("14 FF FF FF 00", "7F 14 13"),
        ("14 00 00 01", "7F 14 31"),
    ],
)
def test_what_cannot_be_answered_is_refused_with_its_reason(memory, request_, refused):
    assert answer(memory, bytes.fromhex(request_)) == bytes.fromhex(refused)


def test_clearing(memory):
    assert answer(memory, bytes.fromhex("14 5A 02 62")) == b"\x54"
    assert memory.entries["a"].stored
    assert answer(memory, bytes.fromhex("14 FF FF FF")) == b"\x54"
    assert not memory.entries["a"].stored
