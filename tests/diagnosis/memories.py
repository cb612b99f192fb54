"""A small table of trouble codes and what tests do with it."""

from __future__ import annotations

import numpy as np

from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import TroubleCode, TroubleCodes


def table(**codes: TroubleCode) -> TroubleCodes:
    return TroubleCodes(codes, {"vehicle_speed": 0xD001, "yaw_rate": 0xD006})


def code(number: int, **fields) -> TroubleCode:
    return TroubleCode(f"C1A{number:02X}-62", f"trouble {number}", "friction", **fields)


def drive(memory: FaultMemory, results: dict, seconds: float = 10.0, rate: float = 10.0, date: str = "2026-01-01"):
    """One operation cycle; a result is one number throughout, or (number before, instant, number after)."""
    time = np.arange(round(seconds * rate)) / rate
    columns = {}
    for name, given in results.items():
        before, instant, after = given if isinstance(given, tuple) else (given, 0.0, given)
        columns[name] = np.where(time < instant, before, after)
    memory.begin_cycle(date)
    changes = memory.absorb(time, columns, {"vehicle_speed": 10.0 + time, "yaw_rate": np.sin(time)})
    memory.end_cycle()
    return changes
