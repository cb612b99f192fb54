"""Fault memory: turns test results into trouble codes with status, history and freeze frames."""

from __future__ import annotations

import datetime
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.files import expanded, holding
from tierod.core.graph import Memory, scan
from tierod.core.signals import SIGNALS
from tierod.diagnosis import store
from tierod.diagnosis.entry import AFTER, BEFORE, CodeStatus, Entry, Window, after_test, begun, displaced, ended, failed
from tierod.diagnosis.trouble_codes import REACTIONS, DebounceCounters, TroubleCodes, load_trouble_codes

CAUSE_DELAY = 2.0  # Longest delay by which a slower cause may fail after its consequence and still replace it [s]
PLACES = 24  # Number of codes that the memory can hold
# Number of recording fingerprints that the memory can hold: a year of three recordings a day, about 100 kB
RECORDINGS = 1000


class Change(NamedTuple):
    """A new verdict: time of the change [s], name of the code, and verdict (1 failed, -1 passed)."""

    time: float
    name: str
    verdict: int


class Counting:
    """Debounce counters and verdicts of all codes within an operation cycle."""

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


class FaultMemory:
    """Fault memory: debounced test results as trouble codes over many operation cycles.

    With a path, every status change is on disk before `absorb` returns.

    Source: ISO 14229-1:2020, annex D; the failure management of Reinelt, Lundquist, Johansson, section "Functional
    safety".

    Args:
        path: of a new file; None for a memory without file; `opened` continues with an existing file
        places: number of codes that it can hold; a further one displaces the least important
    """

    def __init__(
        self,
        codes: TroubleCodes | None = None,
        vehicle: str = "",
        path: str | Path | None = None,
        places: int = PLACES,
    ):
        self.codes = codes or load_trouble_codes()
        self.vehicle, self.path, self.places = vehicle, expanded(path) if path else None, places
        self.entries: dict[str, Entry] = {name: Entry() for name in self.codes.codes}
        self.cycles, self.open, self.date, self.overflowed = 0, False, "", False
        self._counting = Counting(self.codes)
        self._window = Window()
        self._waiting: dict[str, float] = {}
        self._before: dict[str, tuple[float, Entry]] = {}
        self.recordings: dict[str, tuple[int, str]] = {}
        self._digest = ""
        self._live = self._held = False

    @classmethod
    @contextmanager
    def changing(
        cls, path: str | Path, vehicle: str | None = None, codes: TroubleCodes | None = None
    ) -> Iterator[FaultMemory]:
        """Open the memory in a file under a lock; changes are written at the end of the block."""
        with holding(path) as target:
            memory = cls.opened(target, vehicle, codes)
            memory._held = True
            yield memory
            memory._digest = store.save_held(target, memory.codes, memory.vehicle, memory._content(), memory._digest)
            memory._held = False

    @classmethod
    def opened(cls, path: str | Path, vehicle: str | None = None, codes: TroubleCodes | None = None) -> FaultMemory:
        memory = cls(codes, vehicle or "", path)
        assert memory.path
        if memory.path.exists():
            kept = store.load(memory.path, memory.codes, vehicle)
            memory.entries |= kept.entries
            memory.cycles, memory.date = kept.content["cycles"], kept.content["date"]
            memory.open, memory.overflowed = kept.content["open"], kept.content["overflowed"]
            memory.recordings = {key: tuple(each) for key, each in kept.content.get("recordings", {}).items()}
            memory._digest, memory.vehicle = kept.digest, kept.vehicle
        return memory

    def begin_cycle(self, date: str | None = None, recording: str = "") -> None:
        """Begin an operation cycle, a drive or one recording; one left open by a crashed program is ended first."""
        if self.open and self._live:
            raise ParameterError("an operation cycle is open; end it before the next begins")
        if recording in self.recordings:
            number, taken = self.recordings[recording]
            raise InputError(
                f"the fault memory {self.path or 'in this program'} already contains this recording, as operation "
                f"cycle {number} on {taken}, and counts none twice: nothing was changed. Judge it again without the "
                "memory"
            )
        if self.open:
            self._close()
        self._live = True
        self.open, self.cycles = True, self.cycles + 1
        self.date = date or datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        if recording:
            # In order of insertion: the oldest fingerprints are dropped.
            self.recordings = dict(list(self.recordings.items())[1 - RECORDINGS :])
            self.recordings[recording] = (self.cycles, self.date)
        self.entries = {name: begun(entry) for name, entry in self.entries.items()}
        self._counting.restart()
        self._window = Window()
        self._waiting, self._before = {}, {}
        self.save()

    def absorb(
        self, time: np.ndarray, results: Mapping[str, np.ndarray], signals: Mapping[str, np.ndarray] | None = None
    ) -> tuple[tuple[float, str, str], ...]:
        if not self._live:
            raise ParameterError("no operation cycle is open; begin one before adding results")
        time = np.asarray(time, float)
        self._check(time, results, signals or {})
        listed = [name for name in signals or {} if name in self.codes.identifiers]
        self._window.add(time, {name: np.asarray((signals or {})[name], float) for name in listed})
        changes = self._counting.add(time, results)
        for change in changes:
            self._apply(*change)
        for name, entry in self.entries.items():
            counter, verdict = self._counting.of(name)
            self.entries[name] = entry.with_(counter=counter, verdict=verdict)
        if len(time):
            framed = self._frames(float(time[-1]))
            self._window.forget(float(time[-1]) - BEFORE - AFTER)
            if changes or framed:
                self.save()
        return tuple((each.time, each.name, "failed" if each.verdict > 0 else "passed") for each in changes)

    def end_cycle(self) -> None:
        """End the operation cycle: update pending codes, healing and aging."""
        if not self._live:
            raise ParameterError("no operation cycle is open; there is none to end")
        self._frames(np.inf)
        self._close()
        self.save()

    def _close(self) -> None:
        self.entries = {name: ended(entry, self.codes.codes[name]) for name, entry in self.entries.items()}
        self.open = self._live = False

    def clear(self, name: str | None = None) -> None:
        """Clear one code, given its name or the code itself, or all codes and recordings; other codes are unaffected.

        Within a cycle the test of a cleared code starts again, so that a persistent fault becomes pending again.
        """
        chosen = tuple(self.entries) if name is None else (self.codes.named(name),)
        self.recordings = {} if name is None else self.recordings
        self.overflowed = self.overflowed and name is not None
        for each in chosen:
            self.entries[each] = Entry()
            self._waiting.pop(each, None)
            self._before.pop(each, None)
        self._counting.forget(chosen)
        self.save()

    @property
    def lamp(self) -> bool:
        """Whether the warning lamp is requested."""
        return any(entry.status & CodeStatus.WARNING_REQUESTED for entry in self.entries.values())

    @property
    def reaction(self) -> str:
        """Strongest reaction of the confirmed codes whose tests fail at present."""
        wanted = CodeStatus.CONFIRMED | CodeStatus.TEST_FAILED
        asked = [
            REACTIONS.index(self.codes.codes[name].reaction)
            for name, entry in self.entries.items()
            if wanted in entry.status
        ]
        return REACTIONS[max(asked, default=0)]

    def save(self) -> None:
        """Write the file atomically; does nothing without a path, or within `changing`, which writes at its end."""
        if self.path is not None and not self._held:
            self._digest = store.save(self.path, self.codes, self.vehicle, self._content(), self._digest)

    def _content(self) -> dict[str, Any]:
        return {
            "cycles": self.cycles,
            "date": self.date,
            "open": self.open,
            "overflowed": self.overflowed,
            "recordings": self.recordings,
            "entries": {name: entry.document() for name, entry in self.entries.items()},
        }

    def _check(self, time: np.ndarray, results: Mapping[str, np.ndarray], signals: Mapping[str, np.ndarray]) -> None:
        for name in results:
            if name not in self.entries:
                raise InputError(f"there is no trouble code '{name}'{nearest(name, self.entries)}")
        for name in signals:
            if name not in SIGNALS:
                raise InputError(f"there is no signal '{name}'{nearest(name, SIGNALS)}")
        for name, values in (*results.items(), *signals.items()):
            if np.shape(values) != time.shape:
                raise InputError(f"'{name}' has the shape {np.shape(values)}; expected {time.shape}, as the time has")
        before = self._window.time[-1:]
        if not (np.isfinite(time).all() and (np.diff(np.concatenate([before, time])) > 0.0).all()):
            raise InputError("the times of the results must be finite and increase; sort them, and leave none out")

    def _apply(self, instant: float, name: str, verdict: int) -> None:
        entry, code = self.entries[name], self.codes.codes[name]
        if verdict < 0:
            passed = after_test(entry.status, failed=False)
            self.entries[name] = entry.with_(status=passed, verdict=-1, consequence_of="")
            return
        causes = sorted(cause for cause in self._counting.causes[name] if self.entries[cause].verdict > 0)
        if causes:
            self.entries[name] = entry.with_(verdict=1, consequence_of=causes[0])
            return
        self._before[name] = (instant, entry)
        self.entries[name] = failed(entry, code)
        self._waiting[name] = instant
        self._take_back(instant, name)
        self._make_room(name)

    def _take_back(self, instant: float, cause: str) -> None:
        for name, (since, entry) in list(self._before.items()):
            if (
                cause in self._counting.causes[name]
                and instant - since <= CAUSE_DELAY
                and self.entries[name].verdict > 0
            ):
                self.entries[name] = entry.with_(verdict=1, consequence_of=cause)
                self._waiting.pop(name, None)

    def _make_room(self, newest: str) -> None:
        stored = [name for name, entry in self.entries.items() if entry.stored]
        if len(stored) <= self.places:
            return
        failing = {name for name in stored if self.entries[name].status & CodeStatus.TEST_FAILED}
        # The least important code is displaced; among equals one that is not failing now, and rather not the newest.
        least = max(stored, key=lambda name: (self.codes.codes[name].priority, name not in failing, name != newest))
        self.entries[least] = displaced(self.entries[least])
        self._waiting.pop(least, None)
        self.overflowed = True

    def _frames(self, now: float) -> bool:
        """Take the freeze frames whose time after the failure has passed; returns whether there were any."""
        ready = [name for name, instant in self._waiting.items() if instant + AFTER <= now]
        for name in ready:
            frame = self._window.frame(self.cycles, self.date, self._waiting.pop(name))
            entry = self.entries[name]
            self.entries[name] = entry.with_(first=entry.first or frame, last=frame)
        return bool(ready)
