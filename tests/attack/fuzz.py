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

_INSPECT: Command = ("inspect", FILE)
_JUDGE: Command = ("diagnose", FILE, "--vehicle", "midsize-eps", "--no-report", "--json")


@dataclass(frozen=True)
class Target:
    """Something that opens a file."""

    name: str
    family: str
    commands: tuple[tuple[int, Command], ...]


_READER = ((5, _INSPECT), (2, (*_INSPECT, "--all", "--json")), (3, _JUDGE))
_BUS = (
    (5, (*_INSPECT, "--vehicle", "rav4")),
    (2, (*_INSPECT, "--dbc", "rav4", "--all", "--json")),
    (1, _INSPECT),
    (2, ("diagnose", FILE, "--vehicle", "rav4", "--no-report", "--json")),
)

TARGETS: dict[str, Target] = {
    each.name: each
    for each in (
        Target("csv", "text", _READER),
        Target("packed-csv", "gzip", (*_READER, (3, (*_INSPECT, "--dbc", "rav4")))),
        Target("parquet", "parquet", _READER),
        Target("mf4", "mdf", _READER),
        Target("mf4-bus", "mdf", _BUS),
        Target("mat", "mat", _READER),
        Target("hdf5", "process", _READER),
        Target("arrow", "process", _READER),
        Target("mcap", "process", _READER),
        Target("ros1", "process", _READER),
        Target("ros2", "process", _READER),
        Target("candump", "can-text", _BUS),
        Target("asc", "can-text", _BUS),
        Target("blf", "blf", _BUS),
        Target("trc", "can-text", _BUS),
        Target(
            "vehicle",
            "toml",
            (
                (4, ("vehicles", FILE)),
                (2, ("vehicles", FILE, "--json")),
                (1, ("vehicles", FILE, "--toml")),
                (3, ("diagnose", BESIDE, "--vehicle", FILE, "--no-report", "--json")),
            ),
        ),
        Target(
            "channel-map",
            "toml",
            (
                (6, ("inspect", FITTING, "--dbc", "rav4", "--map", FILE)),
                (1, ("diagnose", FITTING, "--vehicle", "rav4", "--map", FILE, "--no-report", "--json")),
            ),
        ),
        Target(
            "scenario",
            "toml",
            (
                (4, ("scenarios", FILE)),
                (2, ("scenarios", FILE, "--json")),
                (1, ("scenarios", FILE, "--toml")),
                (2, ("simulate", FILE, "--seconds", "0.5", "--output", "drive.csv")),
            ),
        ),
        Target(
            "campaign", "toml", ((3, ("campaign", FILE, "--dry-run")), (1, ("campaign", FILE, "--dry-run", "--json")))
        ),
        Target(
            "fault", "toml", ((3, ("faults", FILE)), (1, ("faults", FILE, "--json")), (1, ("faults", FILE, "--toml")))
        ),
        Target(
            "baseline",
            "json",
            ((1, ("diagnose", BESIDE, "--vehicle", "midsize-eps", "--baseline", FILE, "--no-report", "--json")),),
        ),
        Target(
            "fault-memory",
            "json",
            (
                (3, ("faults", "read", FILE)),
                (2, ("faults", "read", FILE, "--json")),
                (1, ("faults", "read", FILE, "--uds", "1902FF")),
                (1, ("faults", "read", FILE, "--uds", "1906FFFFFF10")),
                (2, ("faults", "snapshot", FILE, "{code}")),
                (1, ("faults", "clear", FILE)),
                (1, ("diagnose", BESIDE, "--vehicle", "midsize-eps", "--memory", FILE, "--no-report", "--json")),
            ),
        ),
        Target(
            "dbc",
            "dbc",
            ((3, ("inspect", FITTING, "--dbc", FILE)), (1, ("inspect", FITTING, "--dbc", FILE, "--all", "--json"))),
        ),
    )
}

READERS = tuple(TARGETS)[:15]


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
