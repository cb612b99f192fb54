"""Runs series of cases, and groups what failed into classes."""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

from .pool import Pool, Result
from .targets import Case, case

SEED = 20261123
"""Of the cases in the suite. Another seed tries other files: `make attack SEED=...`."""

ROUND = 500
"""Cases of a target before the next one has its turn."""

_OF_THE_MACHINE = ("hang", "memory")
"""Failures that other work on the machine, or cases before in the same process, can bring about."""


@dataclass
class Tally:
    """Figures of one target.

    Args:
        cases: how many were run
        codes: how often each exit code came
        failed: the cases that failed, with what became of them
        unrepeated: how many took too long or too much once, and held when they were run again in a fresh process
        slowest: processor time of the slowest case [s]
        largest: memory of the largest case [bytes]
    """

    cases: int = 0
    codes: Counter = field(default_factory=Counter)
    failed: list[tuple[Case, Result]] = field(default_factory=list)
    unrepeated: int = 0
    slowest: float = 0.0
    largest: int = 0

    def add(self, other: Tally) -> None:
        """Take in the figures of another series.

        Args:
            other: series of the same target
        """
        self.cases += other.cases
        self.codes += other.codes
        self.failed += other.failed
        self.unrepeated += other.unrepeated
        self.slowest, self.largest = max(self.slowest, other.slowest), max(self.largest, other.largest)


def attempt(pool: Pool, each: Case) -> Result:
    """Run one case.

    Args:
        pool: that runs it
        each: the case
    """
    return pool.run(each.placed(pool.folder()))


def run(target: str, numbers: Iterable[int], seed: int, pool: Pool, until: float = float("inf")) -> Tally:
    """Run a series of cases of one target; time and memory count where they fail again in a fresh process.

    Args:
        target: its name
        numbers: of the cases
        seed: of the series
        pool: that runs them
        until: time of the monotonic clock at which no further case begins [s]
    """
    tally = Tally()
    for number in numbers:
        if time.monotonic() > until:
            break
        each = case(target, seed, number)
        result = attempt(pool, each)
        tally.cases += 1
        tally.codes[result.code] += 1
        tally.slowest, tally.largest = max(tally.slowest, result.seconds), max(tally.largest, result.memory)
        if result.kind in _OF_THE_MACHINE:
            with Pool() as fresh:
                result = attempt(fresh, each)
            tally.unrepeated += not result.kind
        if result.kind:
            tally.failed.append((each, result))
    return tally


def run_all(
    targets: Sequence[str], count: int, seed: int, workers: int = 2, until: float = float("inf"),
    told: Callable[[str, Tally], None] | None = None,
) -> dict[str, Tally]:  # fmt: skip
    """Run series of all targets, several at a time and in rounds, so that all get on alike where the time is short.

    Args:
        targets: their names
        count: cases of each
        seed: of the series
        workers: processes
        until: time of the monotonic clock at which no further case begins [s]
        told: called with the name and the figures of each target at the end of every round
    """
    found = {target: Tally() for target in targets}

    def one(target: str, numbers: range) -> None:
        with Pool() as pool:
            found[target].add(run(target, numbers, seed, pool, until))
        if told is not None:
            told(target, found[target])

    with ThreadPoolExecutor(workers) as executor:
        for begin in range(0, count, ROUND):
            numbers = range(begin, min(begin + ROUND, count))
            for _ in executor.map(one, targets, [numbers] * len(targets)):
                pass  # an error of the attack itself comes up here
    return found


def class_of(result: Result) -> str:
    """What a failure has in common with others: its kind, and the innermost lines of tierod that led to it."""
    frames = re.findall(r'File "[^"]*/(tierod/[^"]+)", line (\d+), in (\w+)', result.detail)
    lines = [line for line in result.detail.strip().splitlines() if line and not line.startswith(" ")]
    if result.kind == "escape":
        return "escape: a control character in what it prints"
    if frames:
        file, line, function = frames[-1]
        return f"{result.kind}: {file}:{line} {function}: {lines[-1][:110]}"
    return f"{result.kind}: {re.sub(r'[0-9.]+', 'N', result.detail)[:110]}"
