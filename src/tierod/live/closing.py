"""The end of a drive: the fault memory takes it as one operation cycle, a page shows it, baselines are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.findings import Diagnosis
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.live.judge import Judge
from tierod.monitors.several import Judged, NotRun

if TYPE_CHECKING:
    from tierod.monitors.harness.into_memory import MemoryFeed

Results = tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]


def remembered(finished: Sequence[tuple[Judge, Diagnosis, MemoryFeed]]) -> str:
    """One operation cycle of the fault memory, of all monitors together.

    Args:
        finished: judge, diagnosis and what its memory takes, of every monitor that ran; at least one

    Returns:
        what became of it, in a sentence

    Raises:
        InputError: the file of the memory was damaged meanwhile
        OutputError: it cannot be written
    """
    parts = []
    for judge, diagnosis, feed in finished:
        assert judge.run is not None
        parts.append(feed.collected(diagnosis, judge.run.course, judge.run.code_courses))
    time, results, signals = _together(parts)
    first = finished[0][2]
    with FaultMemory.changing(first.path, first.vehicle, load_trouble_codes()) as memory:
        memory.begin_cycle(finished[0][1].created)
        memory.absorb(time, results, signals)
        memory.end_cycle()
    return f"the drive is operation cycle {memory.cycles} of the fault memory {first.path}"


def _together(parts: Sequence[Results]) -> Results:
    """Results and signals of several monitors over one time; without a result, and held, where one has none."""
    time = np.unique(np.concatenate([part[0] for part in parts]))
    results: dict[str, np.ndarray] = {}
    signals: dict[str, np.ndarray] = {}
    for own, codes, measured in parts:
        at = np.searchsorted(time, own)
        for name, values in codes.items():
            results.setdefault(name, np.zeros(len(time)))[at] = values
        before = np.maximum(np.searchsorted(own, time, "right") - 1, 0)
        for name, values in measured.items():
            signals.setdefault(name, values[before])
    return time, results, signals


def page(judges: Sequence[Judge], diagnoses: Mapping[str, Diagnosis], path: Path, vehicle: str) -> Judged:
    """What the monitors found, as `tierod diagnose --monitor all` shows it.

    Args:
        judges: of the drive
        diagnoses: by monitor
        path: of the log, or what stands for it
        vehicle: its name
    """
    missed = tuple(NotRun(each.name, each.reason) for each in judges if each.name not in diagnoses)
    return Judged(path, vehicle, dict(diagnoses), missed)
