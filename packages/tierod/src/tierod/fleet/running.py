"""A fleet run: recordings are found, those without a valid result are judged, and the results are compacted."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from tierod.core.errors import OutputError, ParameterError
from tierod.core.processes import alone
from tierod.fleet import schema
from tierod.fleet.compaction import compact, mark_doubles, mark_overlaps
from tierod.fleet.fleet_file import Fleet
from tierod.fleet.judging import Asked
from tierod.fleet.ledger import Ledger, prepare
from tierod.fleet.places import Found, Place, find, place_of
from tierod.fleet.stamps import code
from tierod.fleet.task import Done, Job, Task, work
from tierod.vehicles import load
from tierod.work.fingerprint import fingerprint
from tierod.work.pool import Failure, Workers

if TYPE_CHECKING:
    import pyarrow as pa

COMPACTED = 5000
"""Number of new results after which the findings are compacted during a run; about 40 MB wait in this process."""


class Progress(NamedTuple):
    """Progress of a run."""

    done: int  # number of finished recordings, including those of earlier runs
    total: int
    name: str = ""  # name of the recording just finished; "" before the first
    outcome: str = ""
    reason: str = ""  # why it was skipped or failed


@dataclass(frozen=True)
class Summary:
    """Summary of a run."""

    results: Place
    recordings: tuple[str, ...]  # names of the recordings found
    kept: int  # number of these whose earlier result is still valid
    rows: Mapping[str, Mapping[str, Any]] = field(repr=False)  # rows of the ledger, by name of the recording
    findings: pa.Table = field(repr=False)  # findings of the whole folder

    @property
    def outcomes(self) -> Counter[str]:
        """Number of recordings by outcome."""
        return Counter(self.rows[name]["outcome"] for name in self.recordings)

    @property
    def hours(self) -> Annotated[float, "h"]:
        """Duration of the judged recordings [h]."""
        seconds = (self.rows[name].get("duration_s") or 0.0 for name in self._judged)
        return sum(seconds) / 3600.0

    @property
    def processor(self) -> Annotated[float, "s"]:
        """Processor time of the judged recordings [s]."""
        return float(sum(self.rows[name].get("processor_s") or 0.0 for name in self._judged))

    @property
    def memory(self) -> int:
        """Largest resident memory of a process that judged [bytes]."""
        return max((self.rows[name].get("memory_bytes") or 0 for name in self._judged), default=0)

    @property
    def statuses(self) -> dict[str, dict[str, int]]:
        """Number of findings of this run by monitor and status."""
        keys = {self.rows[name]["key"] for name in self._judged}
        names = ("key", "monitor", "status")
        counts: dict[str, Counter[str]] = {}
        for key, monitor, status in zip(*(self.findings[each].to_pylist() for each in names), strict=True):
            if key in keys:
                counts.setdefault(monitor, Counter())[status] += 1
        return {monitor: dict(each.most_common()) for monitor, each in sorted(counts.items())}

    @property
    def _judged(self) -> list[str]:
        return [name for name in self.recordings if self.rows[name]["outcome"] == schema.JUDGED]

    @property
    def exit_code(self) -> int:
        """Exit code: 0 if any recording was judged, else 2."""
        return 0 if self._judged else 2


def run(
    recordings: Sequence[str],
    fleet: Fleet,
    results: str | Path,
    asked: Asked,
    workers: Workers,
    *,
    again: bool = False,
    with_levels: bool = True,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Summary:
    place = place_of(results)
    found = [each for each in find(recordings) if not each.path.startswith(f"{place.root}/")]
    prepare(place)
    with _held(place), Ledger(place) as ledger:
        job = Job(place, asked, code(), with_levels)
        plan = _plan(found, fleet, job, ledger, again)
        progress(Progress(plan.kept, len(found)))
        try:
            fresh = _work(plan, ledger, workers, len(found), progress)
        finally:
            ledger.flush()
        mark_doubles(ledger)
        mark_overlaps(ledger)
        findings = compact(place, ledger, fresh)
        ledger.merge()
    return Summary(place, tuple(each.name for each in found), plan.kept, ledger.rows, findings)


@dataclass
class _Plan:
    """Tasks of a run, with the digest of each, and the number of recordings that need none."""

    tasks: list[Task] = field(default_factory=list)
    jobs: list[str] = field(default_factory=list)
    kept: int = 0


def _plan(found: Sequence[Found], fleet: Fleet, job: Job, ledger: Ledger, again: bool) -> _Plan:
    plan = _Plan()
    for each in found:
        try:
            if each.refusal:
                raise _Unreadable(each.refusal)
            looks_inside = fleet.entry(each.name).looks_inside
            assigned = None if looks_inside else fleet.assigned(each.name, {})
        except _Unreadable as error:
            ledger.add(each, "", {"outcome": schema.FAILED, "reason": str(error), "lasting": False, "remarks": []})
            continue
        except ParameterError as error:
            ledger.add(each, "", {"outcome": schema.SKIPPED, "reason": str(error), "lasting": False, "remarks": []})
            continue
        stamp = fingerprint(job.asked, job.code, job.with_levels, fleet if assigned is None else assigned)
        stamp = fingerprint(stamp, _text_of(assigned.parameters) if assigned else "")
        if ledger.holds(each, stamp, again):
            plan.kept += 1
        else:
            plan.tasks.append(Task(job, each, assigned, fleet if assigned is None else None))
            plan.jobs.append(stamp)
    return plan


class _Unreadable(Exception):
    """A recording that cannot be accessed."""


def _text_of(parameters: str) -> bytes:
    """Content of a vehicle file, so that a change is detected; empty for a shipped one, which is part of tierod."""
    path = Path(parameters)
    try:
        return path.read_bytes() if path.suffix == ".toml" else b""
    except OSError:
        return b""


def _work(
    plan: _Plan, ledger: Ledger, workers: Workers, total: int, progress: Callable[[Progress], None]
) -> dict[str, bytes]:
    """Judge the recordings of the plan, and return results that are not in the dataset yet, by their keys."""
    fresh: dict[str, bytes] = {}
    if not plan.tasks:
        return fresh
    with workers as opened:
        opened.start(work, len(plan.tasks))
        _compile(plan)
        done = total - len(plan.tasks)
        for at, result in opened.run(work, plan.tasks):
            task = plan.tasks[at]
            if isinstance(result, Failure):
                row = {"outcome": schema.FAILED, "reason": result.reason, "lasting": result.lasting, "remarks": []}
                result = Done(row if task.assigned is None else row | {"vehicle": task.assigned.vehicle})
            ledger.add(task.found, plan.jobs[at], result.row)
            if result.findings is not None:
                fresh[result.row["key"]] = result.findings
            if len(fresh) >= COMPACTED:
                mark_doubles(ledger)
                ledger.flush()
                compact(ledger.place, ledger, fresh)
                fresh = {}
            done += 1
            progress(Progress(done, total, task.found.name, result.row["outcome"], result.row["reason"]))
    return fresh


def _compile(plan: _Plan) -> None:
    """Compile the kernels of up to four vehicles before the workers start, which would otherwise each compile them."""
    from tierod.core.errors import TierodError
    from tierod.core.graph.kernel import kernel

    names = {task.assigned.parameters for task in plan.tasks if task.assigned is not None}
    for name in sorted(filter(None, names))[:4]:
        try:
            runner = plan.tasks[0].job.asked.runner(load(name))
        except TierodError:
            continue  # reported for each of its recordings
        for block in runner.blocks():
            kernel(block)


@contextmanager
def _held(place: Place) -> Iterator[None]:
    """Lock a local results folder against other runs."""
    with ExitStack() as stack:
        if place.local:
            try:
                stack.enter_context(alone(Path(place.root) / "about.json", patience=0.0))
            except TimeoutError:
                raise OutputError(
                    f"another run of 'tierod fleet' writes to {place.root}; wait for it, or name another --output"
                ) from None
        yield


def document(summary: Summary) -> str:
    """Summary of a run as JSON."""
    reasons: dict[str, list[str]] = {}
    for name in summary.recordings:
        row = summary.rows[name]
        if row["outcome"] != schema.JUDGED:
            reasons.setdefault(f"{row['outcome']}: {row['reason']}", []).append(name)
    content = {
        "schema": f"tierod.fleet-run/{schema.VERSION}",
        "results": summary.results.root,
        "recordings": {"found": len(summary.recordings), "kept": summary.kept, **summary.outcomes},
        "vehicles": len({summary.rows[name].get("vehicle") for name in summary._judged}),
        "hours": summary.hours,
        "processor_s_per_hour": summary.processor / summary.hours if summary.hours else None,
        "memory_bytes": summary.memory,
        "statuses": summary.statuses,
        "not_judged": [{"reason": reason, "recordings": names} for reason, names in reasons.items()],
    }
    return json.dumps(content, ensure_ascii=False, indent=2)
