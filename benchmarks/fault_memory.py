"""Test results per second processed by a fault memory, compared with the same counters in plain Python."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.timing import row
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import TroubleCodes, load_trouble_codes

_EVENTS = 1_000_000
_CODES = 10


@dataclass
class Plain:
    """Debounce counter written by hand."""

    counter: int = 0
    verdict: int = 0

    def feed(self, result: float) -> None:
        if result > 0.5:
            self.counter = min(max(self.counter, 0) + 1, 127)
        elif result < -0.5:
            self.counter = max(min(self.counter, 0) - 1, -128)
        if self.counter == 127:
            self.verdict = 1
        elif self.counter == -128:
            self.verdict = -1


def run() -> list[dict]:
    """Rows of the benchmark table: results per second, and ratio to the peer."""
    shipped = next(iter(load_trouble_codes().codes.values()))
    codes = {
        f"code-{k}": replace(shipped, code=f"C1B{k:02X}-62", increment=1, decrement=1, consequence_of=())
        for k in range(_CODES)
    }
    steps = _EVENTS // _CODES
    instants = np.arange(steps) / 100.0
    results = {name: np.sign(np.sin(instants / 3.0 + k)) for k, name in enumerate(codes)}
    ours, theirs, changes = [], [], 0
    for _ in range(3):
        memory = FaultMemory(TroubleCodes(codes, {}))
        memory.begin_cycle()
        begin = time.perf_counter()
        changes = len(memory.absorb(instants, results))
        ours.append(time.perf_counter() - begin)
    for column in list(results.values())[:2]:
        plain = Plain()
        begin = time.perf_counter()
        for result in column.tolist():
            plain.feed(result)
        theirs.append((time.perf_counter() - begin) / steps)
    value, peer = _EVENTS / min(ours), 1.0 / min(theirs)
    return [
        row(
            "fault-memory", value, "results/s", "plain Python, counters alone", peer,
            codes=float(_CODES), changes=float(changes),
        )
    ]  # fmt: skip
