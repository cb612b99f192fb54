"""Fault memory as C99, safe against power loss, with test vectors from random operation cycles."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tierod.core.signals import SIGNALS
from tierod.core.version import __version__
from tierod.diagnosis.fault_memory import CAUSE_DELAY, PLACES, FaultMemory
from tierod.diagnosis.trouble_codes import TroubleCodes
from tierod.export.c_header import rendered
from tierod.export.subject import identifier

SEED = 20261124
CYCLES, STEPS = 160, 6
QUIET_FROM, QUIET_TO = 45, 130  # Range of cycles without a failure, long enough for healing and aging
# Time between two results [s]; short enough that some causes arrive in time to replace their consequence
STEP_TIME = 0.7

BEGIN, STEP, END, CLEAR = range(4)


def memory_vectors(codes: TroubleCodes, places: int) -> tuple[str, str]:
    """Two tables with the same rows: actions, and the resulting contents of the memory.

    Returns:
        inputs (action, time [ms] or code, result of every code) and expected contents (status, occurrences and
            cause of every code, lamp, overflowed)
    """
    memory, names = FaultMemory(codes, places=places), list(codes.codes)
    inputs, expected = [], []
    for action, number, results in _actions(len(names)):
        if action == BEGIN:
            memory.begin_cycle("2026-01-01")
        elif action == STEP:
            given = {name: results[k : k + 1].astype(float) for k, name in enumerate(names)}
            memory.absorb(np.array([0.001 * number]), given)
        elif action == END:
            memory.end_cycle()
        else:
            memory.clear(None if number < 0 else names[number])
        inputs.append(",".join(map(str, (action, number, *results.tolist()))))
        expected.append(",".join(map(str, _held(memory, names))))
    return "\n".join(inputs) + "\n", "\n".join(expected) + "\n"


def _held(memory: FaultMemory, names: list[str]) -> Iterator[int]:
    for entry in memory.entries.values():
        yield int(entry.status)
        yield entry.occurrences
        yield names.index(entry.consequence_of) if entry.consequence_of else -1
    yield int(memory.lamp)
    yield int(memory.overflowed)


def _actions(count: int) -> Iterator[tuple[int, int, np.ndarray]]:
    random, none = np.random.default_rng(SEED), np.zeros(count, int)
    for cycle in range(CYCLES):
        yield BEGIN, 0, none
        # Most codes fail in some cycles, more than the memory can hold; many have cycles without a result before.
        share = 0.0 if QUIET_FROM <= cycle < QUIET_TO else random.choice([0.05, 0.2, 0.95])
        for step in range(1, STEPS + 1):
            failed, passed = random.random(count) < share, random.random(count) < 0.5
            yield STEP, round(1000.0 * STEP_TIME * step), np.where(failed, 1, np.where(passed, -1, 0))
        yield END, 0, none
        if cycle % 37 == 36:
            yield CLEAR, int(random.integers(count)), none
        elif cycle in (10, CYCLES - 5):
            yield CLEAR, -1, none


NAMES = ("tierod_fault_memory.h", "tierod_fault_memory.c")

# File of the export -> its template
TEMPLATES = {
    NAMES[0]: "memory.h.j2",
    NAMES[1]: "memory.c.j2",
    "Makefile": "memory_Makefile.j2",
    "README.md": "memory_README.md.j2",
    "test/compare.c": "memory_compare.c.j2",
}

# Bytes of a slot's header, of a record without its frames, and of a frame without its values
HEADER, FIXED, FRAME = 24, 20, 12


def fault_memory_files(codes: TroubleCodes, places: int = PLACES) -> Mapping[str, str]:
    """All files of an export, by path in its folder; equal tables give equal bytes."""
    values = _values(codes, places)
    texts = {name: rendered(template, values) for name, template in TEMPLATES.items()}
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
