"""A live session from the options of the command line, which are checked before a bus is opened."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cantools.database.can import Message

    from tierod.live.buses import Address
    from tierod.live.drive import Drive
    from tierod.live.events import Hub

ENDINGS = {"log": (".mf4",), "report": (".html", ".htm")}
"""Permitted file endings by option; another ending would suggest another format."""


@dataclass(frozen=True)
class Wanted:
    """Options of `tierod live`, as described in its help."""

    vehicle: str
    dbc: tuple[Path, ...]
    channel_map: Path | None
    monitors: tuple[str, ...]
    log: Path | None
    report: Path | None
    memory: Path | None
    baselines: Path | None
    period: float
    silence: float
    ignition: str
    fd: bool
    bitrate: int | None


def refuse_unfit(wanted: Wanted) -> None:
    """Refuse options whose errors can be detected without a bus.

    Raises:
        ParameterError: a time or a file ending is not valid
        InputError: the fault memory is damaged, or belongs to another vehicle
        OutputError: a file cannot be written
    """
    from tierod.core.errors import ParameterError
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.diagnosis.trouble_codes import load_trouble_codes
    from tierod.vehicles import load

    for name, value in (("--period", wanted.period), ("--silence", wanted.silence)):
        if not value > 0.0:
            raise ParameterError(f"{name} needs a positive time, not {value:g} s")
    car = load(wanted.vehicle)
    _refuse_endings(wanted)
    targets = [wanted.log, wanted.report, wanted.memory]
    _refuse_what_cannot_be_written(targets, [*wanted.dbc, wanted.channel_map])
    if wanted.memory is not None:
        FaultMemory.opened(wanted.memory, car.name, load_trouble_codes())


def _refuse_endings(wanted: Wanted) -> None:
    from tierod.core.errors import ParameterError

    for name, endings in ENDINGS.items():
        path: Path | None = getattr(wanted, name)
        if path is not None and path.suffix.lower() not in endings:
            later = "; tierod convert writes other formats from it later" if name == "log" else ""
            raise ParameterError(
                f"--{name} writes {endings[0]}, not '{path.name}': name it {path.stem}{endings[0]}{later}"
            )


def _refuse_what_cannot_be_written(targets: list[Path | None], given: list[Path | None]) -> None:
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.files import require_folder

    for place, path in enumerate(targets):
        refuse_to_overwrite(path, [*given, *targets[:place]], "output", "its option")
        if path is not None:
            require_folder(path)


def drive_of(wanted: Wanted, addresses: Sequence[Address]) -> tuple[Drive, Hub]:
    """The session with its buses opened, and the hub of its events.

    Args:
        wanted: options that `refuse_unfit` has accepted
        addresses: addresses of the buses

    Raises:
        ParameterError: there is no database, or none has the ignition signal
        InputError: a file cannot be read, or a bus cannot be opened
    """
    import queue

    from tierod.cli.terminal import command_line, origin
    from tierod.io.readers.dbc import load_databases
    from tierod.live.agreement import disagreements
    from tierod.live.bus_files import bus_files
    from tierod.live.drive import Drive, Outputs
    from tierod.live.engine import Pace
    from tierod.live.events import Hub
    from tierod.live.judge import Plan
    from tierod.live.receiving import receiver
    from tierod.live.traffic import Traffic
    from tierod.monitors.together import usual
    from tierod.vehicles import load

    car = load(wanted.vehicle)
    files = bus_files(car, wanted.dbc, wanted.channel_map)
    paths, database = files.paths, files.database
    _refuse_unknown_ignition(wanted.ignition, database)
    names = wanted.monitors or [each.monitor for each in usual()]
    databases = (word for path in paths for word in ("--dbc", str(path)))
    mapped = ("--map", str(files.map_named)) if files.map_named else ()
    one = wanted.monitors[0] if len(wanted.monitors) == 1 else ""
    memory = ("--memory", str(wanted.memory)) if one and wanted.memory else ()
    reading = ("--vehicle", wanted.vehicle, "--monitor", one or "all", *databases, *mapped, *memory)
    plan = Plan(car, wanted.memory, wanted.baselines, command_line(), reading)
    hub, inbox = Hub(), queue.SimpleQueue[Any]()
    width = 64 if wanted.fd else 8
    outputs = Outputs(wanted.log, wanted.report, wanted.silence, wanted.ignition, width)
    receivers = [receiver(number, each, inbox) for number, each in enumerate(addresses, 1)]
    if len(paths) > 1 and (text := disagreements({path: load_databases([path]) for path in paths})):
        print(f"tierod: {text}", file=sys.stderr)
    pace = Pace(period=wanted.period)
    drive = Drive(receivers, inbox, database, files.channel_map, names, plan, outputs, hub, pace, origin)
    drive.health.traffic = Traffic(wanted.bitrate)
    return drive, hub


def _refuse_unknown_ignition(ignition: str, database: Sequence[Message]) -> None:
    from tierod.core.errors import ParameterError, nearest

    known = [f"{message.name}.{signal.name}" for message in database for signal in message.signals]
    if ignition and ignition not in known:
        raise ParameterError(f"no database has the signal '{ignition}' of --ignition{nearest(ignition, known)}")
