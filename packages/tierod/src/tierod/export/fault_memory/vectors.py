"""Test vectors of the fault memory in C: random operation cycles, and the resulting contents of the one in Python."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import TroubleCodes

SEED = 20261124
CYCLES, STEPS = 160, 6
QUIET_FROM, QUIET_TO = 45, 130
"""Range of cycles without a failure, long enough for healing and aging."""
STEP_TIME = 0.7
"""Time between two results [s]; short enough that some causes arrive in time to replace their consequence."""

BEGIN, STEP, END, CLEAR = range(4)


def memory_vectors(codes: TroubleCodes, places: int) -> tuple[str, str]:
    """Two tables with the same rows: actions, and the resulting contents of the memory.

    Args:
        places: number of codes that the memory can hold

    Returns:
        inputs (action, time [ms] or code, result of every code) and expected contents (status, occurrences and cause of
            every code, lamp, overflowed)
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
