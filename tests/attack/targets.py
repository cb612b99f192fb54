"""What is attacked: fifteen readers and eight kinds of user files, each with the commands that open it."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .formats import mutated
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
    """Something that opens a file.

    Args:
        name: of the target, a key of the seeds
        family: of its format, a key of `formats.FAMILIES`
        commands: each with its weight; one is drawn for every case
    """

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
    """One mutated file and the command that opens it.

    Args:
        target: name of the target
        seed: of the series
        number: in the series
        name: of the file
        content: of the file
        command: arguments of tierod, with places for paths
    """

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
    """A case: the same for the same arguments.

    Args:
        target: a key of `TARGETS`
        seed: of the series
        number: in the series
    """
    chosen = TARGETS[target]
    chance = random.Random(f"{target} {seed} {number}")
    files = seeds()[target]
    name = chance.choice(sorted(files))
    others = [content for other, content in files.items() if other != name] or [files[name]]
    content = mutated(chance, files[name], others, chosen.family)
    weights, commands = zip(*chosen.commands, strict=True)
    return Case(target, seed, number, name, content, chance.choices(commands, weights)[0])
