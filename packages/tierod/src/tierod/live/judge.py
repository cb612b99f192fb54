"""One monitor on a live bus: the run that `diagnose` makes over a recording, fed with pieces as they arrive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Recording
from tierod.monitors.baseline import Baseline, load_baseline
from tierod.monitors.memory import MemoryFeed
from tierod.monitors.run import Ended, Run, channels_of
from tierod.monitors.runner import find
from tierod.monitors.session import opened
from tierod.vehicles import Vehicle

HISTORY, SPACING = 24, 2.0  # Number of past values of each estimate kept for the terminal, and time between them [s]

BINS = 4096
"""Smallest number of bins of a trace: twice what a page shows at once, in memory that does not grow with the drive."""


@dataclass(frozen=True)
class Plan:
    """Settings by which monitors are run."""

    vehicle: Vehicle
    memory: Path | None = None  # file of the fault memory; None for none
    baselines: Path | None = None  # folder with the baseline of each monitor, as NAME.json; None for none
    command: str = ""
    reading: tuple[str, ...] = ()  # options with which `tierod diagnose` reads a log of the drive


@dataclass(frozen=True)
class Shown:
    """Displayed state of a monitor."""

    monitor: str
    status: Status  # status of its current verdict; not available or not ready before it runs
    since: float  # time in the drive at which the status began [s]
    reason: str  # why it does not run; "" if it runs
    values: Mapping[str, float] = field(default_factory=dict)  # newest value of every estimate, by name
    units: Mapping[str, str] = field(default_factory=dict)
    enabled: float = math.nan  # share of the last piece in which it learnt; NaN where it does not report it
    history: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


class _Newest:
    """Keeps the newest values that a run reads and estimates."""

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        self.history: dict[str, tuple[float, ...]] = {}
        self.enabled = math.nan
        self._kept = -math.inf

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        if not len(time):
            return
        last = {name: float(values[-1]) for name, values in shown.items()}
        # Replaced, not changed, since another thread may be reading them.
        self.values = self.values | last
        if time[-1] - self._kept >= SPACING:
            self._kept = float(time[-1])
            self.history = self.history | {
                name: (*self.history.get(name, ()), value)[-HISTORY:] for name, value in last.items()
            }
        if "enabled" in shown:
            self.enabled = float(np.mean(shown["enabled"]))


class Judge:
    """Runs one monitor over one drive.

    Raises:
        ParameterError: there is no such monitor

    `needs` are the channels that it reads; `broken` is whether it cannot continue, and `reason` says why.
    """

    def __init__(self, name: str, plan: Plan):
        self.name, self.plan = name, plan
        self.definition, self.variant = find(name)
        self.run: Run | None = None
        self.reason = "no frame came yet"
        self._newest = _Newest()
        self._feed: MemoryFeed | None = None
        self.broken = False
        self.memory_problem = ""
        """Why the fault memory takes nothing of this drive; "" if it does, or if there is none."""
        self.needs = channels_of(self.definition)
        try:
            opened(self.definition, self.variant, plan.vehicle)
        except TierodError as error:
            self.broken, self.reason = True, str(error)

    def add(self, piece: Recording) -> None:
        """Judge the next piece of the drive; a monitor that cannot take it keeps the reason, and raises nothing."""
        if self.broken:
            return
        try:
            self.run = self.run or self._prepared()
            self.run.add(piece)
            self.reason = self.run.waits
        except TierodError as error:
            self.reason = str(error)
            self.broken = self.run is not None and self.run.begun
            self.run = self.run if self.broken else None

    def _prepared(self) -> Run:
        run = Run(
            self.definition, self.variant, self.plan.vehicle, free=True, baseline=self._baseline(), uncertain=True,
            bins=BINS, kept=self._newest.add,
        )  # fmt: skip
        if self.plan.memory is not None:
            try:
                run.feed = self._feed = MemoryFeed(self.plan.memory, self.plan.vehicle.name, self.definition.name)
            except TierodError as error:  # the verdict does not depend on the memory
                self.memory_problem = str(error)
        return run

    def _baseline(self) -> Baseline | None:
        path = self.baseline_path
        return load_baseline(path) if path is not None and path.exists() else None

    @property
    def baseline_path(self) -> Path | None:
        """Path of the file with its baseline; None without a folder of baselines."""
        return None if self.plan.baselines is None else self.plan.baselines / f"{self.name}.json"

    def shown(self) -> Shown:
        """Current state of the monitor for display."""
        run = self.run  # another thread may set it
        if run is None or self.broken or not run.is_open:
            return Shown(self.name, Status.NOT_AVAILABLE, 0.0, self.reason)
        if run.waits:
            return Shown(self.name, Status.NOT_READY, 0.0, self.reason)
        course = getattr(run.session, "course", ())
        status, since = (course[-1].status, course[-1].time) if course else (Status.NOT_READY, 0.0)
        own = run.session.traces
        values = {name: value for name, value in self._newest.values.items() if name in own}
        history = {name: each for name, each in self._newest.history.items() if name in own}
        return Shown(self.name, status, since, "", values, dict(own), self._newest.enabled, history)

    def conclude(self) -> Ended | None:
        """Conclusion over the drive; None where the monitor did not run."""
        if self.broken:
            return None
        try:
            return None if self.run is None else self.run.conclude()
        except TierodError as error:
            self.reason = str(error)
            return None

    def finish(self, own: Ended, others: Sequence[Ended]) -> tuple[Diagnosis, MemoryFeed | None] | None:
        """Diagnosis over the drive, and feed of the fault memory; None where the diagnosis fails.

        Args:
            others: those of the other monitors of the drive
        """
        assert self.run is not None
        try:
            return self.run.finish(self.plan.command, others, own), self._feed
        except TierodError as error:
            self.reason = str(error)
            return None
