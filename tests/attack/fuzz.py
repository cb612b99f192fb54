"""What is attacked: fifteen readers and eight kinds of user files, each with the commands that open it."""

from __future__ import annotations

import random
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from .formats import mutated
from .pool import Pool, Result
from .seeds import drive_file, seeds

FILE = "{file}"
"""Stands for the mutated file in the arguments of a command."""

BESIDE = "{drive}"
"""Stands for a valid recording beside it."""

FITTING = "{fitting}"
"""Stands for the same, or for a valid bus log where the mutated file is made for one car's bus."""

Command = tuple[str, ...]


@dataclass(frozen=True)
class Target:
    """Something that opens a file: its name, the family of its format, and commands with their weights."""

    name: str
    family: str
    commands: tuple[tuple[int, Command], ...]


_READER = (
    "5 inspect {file}", "2 inspect {file} --all --json",
    "3 diagnose {file} --vehicle midsize-eps --no-report --json",
)  # fmt: skip
_BUS = (
    "5 inspect {file} --vehicle rav4", "2 inspect {file} --dbc rav4 --all --json", "1 inspect {file}",
    "2 diagnose {file} --vehicle rav4 --no-report --json",
)  # fmt: skip
_OPENED: tuple[tuple[str, str, Sequence[str]], ...] = (
    ("csv", "text", _READER),
    ("packed-csv", "gzip", (*_READER, "3 inspect {file} --dbc rav4")),
    ("parquet", "parquet", _READER),
    ("mf4", "mdf", _READER),
    ("mf4-bus", "mdf", _BUS),
    ("mat", "mat", _READER),
    *((name, "process", _READER) for name in ("hdf5", "arrow", "mcap", "ros1", "ros2")),
    ("candump", "can-text", _BUS),
    ("asc", "can-text", _BUS),
    ("blf", "blf", _BUS),
    ("trc", "can-text", _BUS),
    ("vehicle", "toml", (
        "4 vehicles {file}", "2 vehicles {file} --json", "1 vehicles {file} --toml",
        "3 diagnose {drive} --vehicle {file} --no-report --json",
    )),
    ("channel-map", "toml", (
        "6 inspect {fitting} --dbc rav4 --map {file}",
        "1 diagnose {fitting} --vehicle rav4 --map {file} --no-report --json",
    )),
    ("scenario", "toml", (
        "4 scenarios {file}", "2 scenarios {file} --json", "1 scenarios {file} --toml",
        "2 simulate {file} --seconds 0.5 --output drive.csv",
    )),
    ("campaign", "toml", ("3 campaign {file} --dry-run", "1 campaign {file} --dry-run --json")),
    ("fault", "toml", ("3 faults {file}", "1 faults {file} --json", "1 faults {file} --toml")),
    ("baseline", "json", ("1 diagnose {drive} --vehicle midsize-eps --baseline {file} --no-report --json",)),
    ("fault-memory", "json", (
        "3 faults read {file}", "2 faults read {file} --json", "1 faults read {file} --uds 1902FF",
        "1 faults read {file} --uds 1906FFFFFF10", "2 faults snapshot {file} {code}", "1 faults clear {file}",
        "1 diagnose {drive} --vehicle midsize-eps --memory {file} --no-report --json",
    )),
    ("dbc", "dbc", ("3 inspect {fitting} --dbc {file}", "1 inspect {fitting} --dbc {file} --all --json")),
)  # fmt: skip

TARGETS = {
    name: Target(name, family, tuple((int(weight), tuple(words)) for weight, *words in map(str.split, commands)))
    for name, family, commands in _OPENED
}


@dataclass(frozen=True)
class Case:
    """One mutated file and the command that opens it."""

    target: str
    seed: int
    number: int
    name: str
    content: bytes
    command: Command

    @property
    def key(self) -> str:
        """What `replay` takes."""
        return f"{self.target} {self.seed} {self.number}"

    def placed(self, folder: Path) -> list[str]:
        """The arguments, once the files stand in a folder."""
        (folder / self.name).write_bytes(self.content)
        return arguments(self.command, folder, self.name)


def arguments(command: Sequence[str], folder: Path, name: str) -> list[str]:
    """The arguments of a command with paths in place of their names; what lies beside the file is written."""
    drive, bus = folder / "beside.csv", folder / "beside.log"
    places = {FILE: folder / name, BESIDE: drive, FITTING: bus if name.startswith("rav4") else drive}
    if BESIDE in command or FITTING in command:
        drive.write_bytes(drive_file())
        bus.write_bytes(seeds()["candump"]["bus.log"])
    return [str(places[each]) if each in places else _code() if each == "{code}" else each for each in command]


def _code() -> str:
    from tierod.diagnosis.trouble_codes import load_trouble_codes

    return next(iter(load_trouble_codes().codes))


def case(target: str, seed: int, number: int) -> Case:
    """A case: the same for the same arguments."""
    chosen = TARGETS[target]
    chance = random.Random(f"{target} {seed} {number}")
    files = seeds()[target]
    name = chance.choice(sorted(files))
    others = [content for other, content in files.items() if other != name] or [files[name]]
    content = mutated(chance, files[name], others, chosen.family)
    weights, commands = zip(*chosen.commands, strict=True)
    return Case(target, seed, number, name, content, chance.choices(commands, weights)[0])


SEED = 20261123
"""Of the cases in the suite. Another seed tries other files: `make attack SEED=...`."""

ROUND = 500
"""Cases of a target before the next one has its turn."""

_OF_THE_MACHINE = ("hang", "memory")
"""Failures that other work on the machine, or cases before in the same process, can bring about."""


@dataclass
class Tally:
    """Figures of one target."""

    cases: int = 0
    codes: Counter = field(default_factory=Counter)
    failed: list[tuple[Case, Result]] = field(default_factory=list)
    unrepeated: int = 0
    slowest: float = 0.0
    largest: int = 0

    def add(self, other: Tally) -> None:
        """Take in the figures of another series."""
        self.cases += other.cases
        self.codes += other.codes
        self.failed += other.failed
        self.unrepeated += other.unrepeated
        self.slowest, self.largest = max(self.slowest, other.slowest), max(self.largest, other.largest)


def attempt(pool: Pool, each: Case) -> Result:
    """Run one case."""
    return pool.run(each.placed(pool.folder()))


def run(target: str, numbers: Iterable[int], seed: int, pool: Pool, until: float = float("inf")) -> Tally:
    """Run a series of cases of one target; time and memory count where they fail again in a fresh process."""
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
    report: Callable[[str, Tally], None] | None = None,
) -> dict[str, Tally]:  # fmt: skip
    """Run series of all targets, several at a time and in rounds, so that all get on alike where the time is short."""
    found = {target: Tally() for target in targets}

    def one(target: str, numbers: range) -> None:
        with Pool() as pool:
            found[target].add(run(target, numbers, seed, pool, until))
        if report is not None:
            report(target, found[target])

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
