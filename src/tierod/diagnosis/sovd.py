"""Fault memory in the format of service-oriented vehicle diagnostics (SOVD): the resource `faults`."""

from __future__ import annotations

from typing import Any

from tierod.core.errors import ParameterError
from tierod.core.signals import SIGNALS
from tierod.diagnosis.entry import Entry, FreezeFrame
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.status import CodeStatus

_BITS = {
    "testFailed": CodeStatus.TEST_FAILED,
    "testFailedThisOperationCycle": CodeStatus.FAILED_THIS_CYCLE,
    "pendingDTC": CodeStatus.PENDING,
    "confirmedDTC": CodeStatus.CONFIRMED,
    "testNotCompletedSinceLastClear": CodeStatus.NOT_COMPLETED_SINCE_CLEAR,
    "testFailedSinceLastClear": CodeStatus.FAILED_SINCE_CLEAR,
    "testNotCompletedThisOperationCycle": CodeStatus.NOT_COMPLETED_THIS_CYCLE,
    "warningIndicatorRequested": CodeStatus.WARNING_REQUESTED,
}


def faults(memory: FaultMemory, everything: bool = False) -> dict[str, Any]:
    """Response to GET /faults: one item per stored code.

    Args:
        memory: whose codes are listed
        everything: whether to list also the codes of the table that are not stored

    Source: ASAM SOVD 1.0, "faults" (ISO 17978-3).
    """
    chosen = [name for name, entry in memory.entries.items() if everything or entry.stored]
    return {"items": [_item(memory, name) for name in chosen]}


def fault(memory: FaultMemory, name_or_code: str) -> dict[str, Any]:
    """Response to GET /faults/{code}: the item with its environment data.

    Raises:
        ParameterError: the code does not exist, or is not stored
    """
    name = memory.codes.named(name_or_code)
    entry = memory.entries[name]
    if not entry.stored:
        raise ParameterError(
            f"the memory has no entry of {memory.codes.codes[name].code} ({name}): it has not failed since it was "
            "cleared, has aged out, or was replaced by another"
        )
    return {"item": _item(memory, name), "environment_data": _environment(entry)}


def _item(memory: FaultMemory, name: str) -> dict[str, Any]:
    code, entry = memory.codes.codes[name], memory.entries[name]
    status: dict[str, str] = {key: str(int(bool(entry.status & bit))) for key, bit in _BITS.items()}
    status["mask"] = f"{int(entry.status):02X}"
    status["aggregatedStatus"] = _aggregated(entry)
    return {
        "code": f"{code.number:06X}",
        "scope": "Default",
        "display_code": code.code,
        "fault_name": code.meaning,
        "fault_translation_id": f"{name}_tid",
        "severity": code.severity,
        "status": status,
    }


def _aggregated(entry: Entry) -> str:
    if entry.status & CodeStatus.TEST_FAILED:
        return "active"
    return "passive" if entry.stored else "cleared"


def _environment(entry: Entry) -> dict[str, Any]:
    frames = (("first_occurrence", entry.first), ("last_occurrence", entry.last))
    return {
        "extended_data_records": {
            "occurrence_counter": entry.occurrences,
            "debounce_counter": entry.counter,
            "failed_operation_cycles": entry.failed_cycles,
            "passed_operation_cycles": entry.passed_cycles,
            "consequence_of": entry.consequence_of or None,
        },
        "snapshots": [snapshot(key, frame) for key, frame in frames if frame is not None],
    }


def snapshot(name: str, frame: FreezeFrame) -> dict[str, Any]:
    """A freeze frame: values at the instant of the failure, and signals around it."""
    at = frame.at_instant()
    return {
        "name": name,
        "operation_cycle": frame.cycle,
        "date": frame.date,
        "time": frame.instant,
        "data": [{"name": key, "unit": SIGNALS[key].unit, "value": value} for key, value in at.items()],
        "around": {"time": list(frame.time), "values": {key: list(each) for key, each in frame.values.items()}},
    }
