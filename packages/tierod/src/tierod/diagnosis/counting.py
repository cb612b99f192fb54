"""Debounce counters of a table of trouble codes, run over test results piece by piece."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.graph import Memory, scan
from tierod.diagnosis.debounce import DebounceCounters
from tierod.diagnosis.trouble_codes import TroubleCodes


class Change(NamedTuple):
    """A new verdict: time of the change [s], name of the code, and verdict (1 failed, -1 passed)."""

    time: float
    name: str
    verdict: int


class Counting:
    """Debounce counters and verdicts of all codes within an operation cycle.

    Args:
        codes: table of trouble codes
    """

    def __init__(self, codes: TroubleCodes):
        self.names = tuple(codes.codes)
        self.causes = {name: codes.causes(name) for name in self.names}
        self._bank = DebounceCounters(
            tuple(code.debounce for code in codes.codes.values()),
            tuple(tuple(sorted(self.names.index(cause) for cause in self.causes[name])) for name in self.names),
        )
        self._state: Memory | None = None

    def restart(self) -> None:
        """Reset all counters."""
        self._state = None

    def forget(self, names: Collection[str]) -> None:
        """Reset the counters of some codes, so that a persistent fault is reported again; the others continue."""
        if self._state is not None:
            counted = self._counted()
            counted[[self.names.index(name) for name in names]] = 0.0
            self._state = replace(self._state, values=counted.ravel())

    def add(self, time: np.ndarray, results: Mapping[str, np.ndarray]) -> list[Change]:
        """Count results, (n,) each by name; returns new verdicts ordered by time, causes before consequences."""
        table = np.zeros((len(time), len(self.names)))
        for name, values in results.items():
            table[:, self.names.index(name)] = values
        held = self._counted()[:, 1]
        done = scan(self._bank, table, self._state)
        self._state = done.state
        verdicts = done.values
        # A change to 0 only suspends a consequence while its cause has failed; it is no new verdict.
        rows, columns = np.nonzero(verdicts * np.diff(np.vstack([held, verdicts]), axis=0))
        found = [Change(float(time[r]), self.names[c], int(verdicts[r, c])) for r, c in zip(rows, columns, strict=True)]
        return sorted(found, key=lambda change: (change.time, len(self.causes[change.name])))

    def of(self, name: str) -> tuple[int, int]:
        """Present counter and verdict of a code."""
        counter, verdict = self._counted()[self.names.index(name)]
        return int(counter), int(verdict)

    def _counted(self) -> np.ndarray:
        """Present counters and verdicts of all codes, (codes, 2)."""
        if self._state is None:
            return np.zeros((len(self.names), 2))
        return np.array(self._state.values).reshape(-1, 2)
