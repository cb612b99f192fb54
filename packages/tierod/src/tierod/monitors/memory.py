"""A drive as an operation cycle of a fault memory."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from tierod.core.files import require_folder
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Aligned, Recording
from tierod.core.series import Rows, Stride
from tierod.diagnosis.fault_memory import Counting, FaultMemory
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.io.derive import ingredients
from tierod.monitors.session import Monitor, StatusChange

RATE = 10.0
"""Rate of the test results in the memory [Hz]; low, since the stopping rule of the monitor has decided already."""


class MemoryFeed:
    """Collects the results of a run for a fault memory, which is read again and written at the end.

    Args:
        path: path of the memory; the file need not exist

    Raises:
        InputError: the file is damaged, or belongs to another vehicle
        OutputError: its folder is missing or cannot be written
    """

    def __init__(self, path: str | Path, vehicle: str, monitor: str):
        memory = FaultMemory.opened(path, vehicle, load_trouble_codes())
        require_folder(path)
        self.path, self.vehicle, self.monitor = path, vehicle, monitor
        self.codes, self.identifiers = memory.codes.of_monitor(monitor), memory.codes.identifiers
        # Compile the counters now: during the transaction at the end, compiling would block all other writers.
        Counting(memory.codes).add(np.zeros(1), {})
        self._names: tuple[str, ...] = ()
        self._rows: Rows | None = None
        self._stride: Stride | None = None

    def add(self, aligned: Aligned, rate: float) -> None:
        """Add the signals of one more piece, with the rate of its grid [Hz]."""
        self._stride = self._stride or Stride(max(round(rate / RATE), 1))
        kept = self._stride.over(len(aligned.time))
        if self._rows is None:
            self._names = tuple(name for name in self.identifiers if name in aligned.names)
            self._rows = Rows(1 + len(self._names))
        columns = (aligned.values[kept, aligned.names.index(name)] for name in self._names)
        self._rows.add(np.column_stack([aligned.time[kept], *columns]))

    def finish(
        self,
        diagnosis: Diagnosis,
        course: Sequence[StatusChange],
        code_courses: Mapping[str, Sequence[StatusChange]] | None = None,
        recording: str = "",
    ) -> str:
        """Write the run as one operation cycle: every status as a test result, and the verdict as the last one."""
        time, results, signals = self.collected(diagnosis, course, code_courses)
        # Opened here, not kept since the beginning: other recordings of the vehicle may have been judged meanwhile.
        with FaultMemory.changing(self.path, self.vehicle, load_trouble_codes()) as memory:
            memory.begin_cycle(diagnosis.created, f"{self.monitor} {recording}" if recording else "")
            memory.absorb(time, results, signals)
            memory.end_cycle()
        return f"the recording is operation cycle {memory.cycles} of the fault memory {self.path}"

    def collected(
        self,
        diagnosis: Diagnosis,
        course: Sequence[StatusChange],
        code_courses: Mapping[str, Sequence[StatusChange]] | None = None,
    ) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Time [s], results by trouble code and signals by name of the run; arguments as of `finish`."""
        assert self._rows is not None
        time, *columns = self._rows.values.T
        signals = dict(zip(self._names, columns, strict=True))
        last = diagnosis.findings[0].status
        results = {}
        for name, code in self.codes.items():
            # Without a course the vehicle lacks that part: its code was not tested, which is not the same as passed.
            own = code_courses.get(name, [StatusChange(0.0, Status.NOT_READY)]) if code_courses else None
            status = _statuses(time, course, last) if own is None else _statuses(time, own, own[-1].status)
            results[name] = np.select(
                [np.isin(status, code.failed_by), np.isin(status, code.passed_by)], [1.0, -1.0], 0.0
            )
        return time, results, signals


def _statuses(time: np.ndarray, course: Sequence[StatusChange], last: Status) -> np.ndarray:
    names = np.array([Status.NOT_READY, *(change.status for change in course)], dtype=object)
    found = names[np.searchsorted([change.time for change in course], time, "right")]
    # The verdict may differ from the running one, which does not include defects of the inputs.
    found[-1] = last
    return found.astype(str)


class SampleDigest:
    """SHA-256 over time stamps and values; it does not depend on how the recording is cut into pieces.

    Args:
        names: channels to be included, if the recording has them
    """

    def __init__(self, names: Iterable[str]):
        self._digests = {name: hashlib.sha256(name.encode()) for name in sorted(names)}

    def add(self, piece: Recording) -> None:
        """Add the next piece of the recording."""
        for name, digest in self._digests.items():
            if name in piece:
                channel = piece[name]
                digest.update(np.column_stack([channel.time, channel.values]).astype("<f8").tobytes())

    def result(self) -> str:
        """First 32 hexadecimal digits of the digest over all pieces."""
        whole = hashlib.sha256(b"".join(digest.digest() for digest in self._digests.values()))
        return whole.hexdigest()[:32]


def read_by_all(monitor: Monitor) -> set[str]:
    """Channels that all own variants read, so that the fingerprint of a recording depends on no variant or package."""
    names = getattr(monitor.variants, "own", monitor.variants)
    own = [monitor, *(monitor.needing(monitor.variants[each]) for each in names)]
    return set.intersection(*(set(ingredients([*each.required, *each.optional])) for each in own))
