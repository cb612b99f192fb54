"""Fault memory as C99: debouncing, status bytes, healing, aging, freeze frames, and storage safe against power loss."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tierod.core.signals import SIGNALS
from tierod.core.version import __version__
from tierod.diagnosis.fault_memory import CAUSE_DELAY, PLACES
from tierod.diagnosis.trouble_codes import TroubleCodes
from tierod.export.fault_memory.vectors import CYCLES, memory_vectors
from tierod.export.members import identifier
from tierod.export.templates import rendered

NAMES = ("tierod_fault_memory.h", "tierod_fault_memory.c")

TEMPLATES = {
    NAMES[0]: "memory.h.j2",
    NAMES[1]: "memory.c.j2",
    "Makefile": "Makefile.j2",
    "README.md": "README.md.j2",
    "test/compare.c": "compare.c.j2",
}
"""File of the export -> its template."""

HEADER, FIXED, FRAME = 24, 20, 12
"""Bytes of a slot's header, of a record without its frames, and of a frame without its values."""


def fault_memory_files(codes: TroubleCodes, places: int = PLACES) -> Mapping[str, str]:
    """All files of an export, by path in its folder; equal tables give equal bytes.

    Args:
        places: number of codes that the memory can hold
    """
    values = _values(codes, places)
    texts = {name: rendered(Path(__file__).parent, template, values) for name, template in TEMPLATES.items()}
    inputs, expected = memory_vectors(codes, places)
    return {**texts, "test/inputs.csv": inputs, "test/expected.csv": expected}


def _values(codes: TroubleCodes, places: int) -> dict[str, object]:
    names, signals = list(codes.codes), list(codes.identifiers)
    record = FIXED + 2 * (FRAME + 4 * len(signals))
    rows: list[dict[str, Any]] = []
    causes: list[int] = []
    for name, code in codes.codes.items():
        own = [names.index(each) for each in sorted(codes.causes(name))]
        rows.append(
            {
                "macro": identifier(name).upper(), "code": code.code, "meaning": code.meaning.replace("*/", "* /"),
                "increment": code.increment, "decrement": code.decrement, "jump": _truth(code.jump),
                "priority": code.priority, "confirmation": code.confirmation_cycles, "healing": code.healing_cycles,
                "aging": code.aging_cycles, "lamp": _truth(code.lamp), "causes": own, "first": len(causes),
            }
        )  # fmt: skip
        causes += own
    digest = int.from_bytes(hashlib.sha256(repr((rows, signals, places)).encode()).digest()[:4], "big")
    return {
        "codes": rows,
        "signals": [{"macro": identifier(each).upper(), "unit": SIGNALS[each].unit} for each in signals],
        "causes": causes or [0],
        "depth": max(len(row["causes"]) for row in rows),
        "places": places,
        "record": record,
        "slot": HEADER + record * len(rows) + 4,
        "cycles": CYCLES,
        "cause_delay": round(1000.0 * CAUSE_DELAY),
        "digest": f"0x{digest:08X}",
        "version": f"tierod {__version__}",
    }


def _truth(value: bool) -> str:
    return "true" if value else "false"
