"""Follow live buses: verdicts while driving, a log that survives a kill, fault memory and report at the end."""

from __future__ import annotations

import contextlib
import shlex
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cantools.database.can import Message

    from tierod.live.buses import Address
    from tierod.live.drive import Drive
    from tierod.live.events import Hub, Socket
    from tierod.live.results import Sender


def live(
    interface: Annotated[str, typer.Option(help="Interface of python-can: socketcan, vector, udp_multicast, ...")],
    channel: Annotated[list[str], typer.Option(help="Channel of the interface; once for every bus.")],
    vehicle: Annotated[str, typer.Option(help="A vehicle's name or the path of its TOML file.")],
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; the vehicle's own where not given.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    monitor: Annotated[
        list[str] | None, typer.Option(help="What to watch; every monitor that can run where not given.")
    ] = None,
    log: Annotated[Path | None, typer.Option(help="MF4 file that takes every frame as it comes.")] = None,
    mcap: Annotated[Path | None, typer.Option(help="MCAP file of signals, estimates and findings.")] = None,
    send: Annotated[str | None, typer.Option(help="Channel of the interface to which results are sent.")] = None,
    results_dbc: Annotated[Path | None, typer.Option(help="DBC of the results; it is written.")] = None,
    memory: Annotated[Path | None, typer.Option(help="Fault memory; every drive is one operation cycle.")] = None,
    report: Annotated[Path | None, typer.Option(help="HTML page at the end of the drive.")] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(help="File that keeps the states of the monitors; they go on from it.")
    ] = None,
    baselines: Annotated[Path | None, typer.Option(help="Folder with the baseline that each monitor learnt.")] = None,
    bitrate: Annotated[int | None, typer.Option(help="Bit rate [bit/s]; as the driver has it where not given.")] = None,
    fd: Annotated[bool, typer.Option("--fd", help="Frames of CAN FD come.")] = False,
    period: Annotated[float, typer.Option(help="Time between two pieces of the drive [s].")] = 2.0,
    silence: Annotated[float, typer.Option(help="Time without a frame after which the drive has ended [s].")] = 30.0,
    ignition: Annotated[
        str, typer.Option(help='Signal of a database, as "Message.Signal", whose zero ends the drive.')
    ] = "",
    drives: Annotated[int, typer.Option(help="End after so many drives; 0 goes on.")] = 0,
    seconds: Annotated[float, typer.Option(help="End after this time [s]; 0 goes on until Ctrl-C.")] = 0.0,
    websocket: Annotated[int | None, typer.Option(help="Port on this computer for the events; 0 takes any.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Events as JSON lines, as without a terminal.")] = False,
) -> int:
    """Follow live buses until Ctrl-C: healthy (0), fault (1), could not judge (2), bad input (3)."""
    from tierod.core.errors import ParameterError
    from tierod.live.buses import Address
    from tierod.live.quiet import quiet
    from tierod.vehicles import load

    for name, value in (("--period", period), ("--silence", silence)):
        if not value > 0.0:
            raise ParameterError(f"{name} needs a positive time, not {value:g} s")
    load(vehicle)
    if (send is None) != (results_dbc is None):
        raise ParameterError("--send sends results by a DBC: give both --send CHANNEL and --results-dbc FILE")
    _refuse_what_cannot_be_written([log, mcap, results_dbc, report, checkpoint, memory], [*(dbc or []), channel_map])
    addresses = [Address(interface, each, bitrate, fd) for each in channel]
    drive, hub = _drive(
        addresses, vehicle, dbc, channel_map, monitor, (log, mcap, report, checkpoint, memory, baselines),
        (period, silence), ignition, fd, bitrate,
    )  # fmt: skip
    with contextlib.ExitStack() as stack:
        if send and results_dbc:
            stack.callback(_sender(drive, Address(interface, send, bitrate, fd), results_dbc).close)
        if websocket is not None:
            stack.callback(_socket(hub, websocket).close)
        _end_cleanly(drive)
        stack.enter_context(quiet())
        return _followed(drive, drives, seconds, as_json or not sys.stdout.isatty())


def _socket(hub: Hub, port: int) -> Socket:
    """Events go to whoever connects to the port."""
    from tierod.live.events import Socket

    socket = Socket(port)
    hub.add(socket)
    print(f"events: ws://127.0.0.1:{socket.port}", file=sys.stderr)
    return socket


def _sender(drive: Drive, address: Address, path: Path) -> Sender:
    """Results go to a bus ten times a second while a drive is judged."""
    from tierod.core.errors import TierodError
    from tierod.live.results import Sender

    sender = Sender(address, path)
    drive.own = sender.identifiers

    def look(now: float) -> None:
        if drive.engine.tally.frames:
            try:
                sender.send(drive.engine.shown(), now)
            except TierodError as error:
                drive.once("results", str(error))

    drive.looking.append(look)
    return sender


def _drive(
    addresses: list[Address],
    vehicle: str,
    dbc: list[Path] | None,
    channel_map: Path | None,
    monitor: list[str] | None,
    files: tuple[Path | None, ...],
    times: tuple[float, float],
    ignition: str,
    fd: bool,
    bitrate: int | None = None,
) -> tuple[Drive, Any]:
    import queue

    from tierod.cli.terminal import origin
    from tierod.core.errors import ParameterError
    from tierod.io.readers.dbc import load_databases
    from tierod.io.readers.opening import shipped
    from tierod.io.readers.streaming import loaded_map
    from tierod.live.agreement import disagreements
    from tierod.live.drive import Drive, Outputs
    from tierod.live.engine import Pace
    from tierod.live.events import Hub
    from tierod.live.judge import Plan
    from tierod.live.receiving import receiver
    from tierod.live.traffic import Traffic
    from tierod.monitors.registry import MONITORS
    from tierod.vehicles import load

    car = load(vehicle)
    given = dbc or ([car.database] if car.database else [])
    if not given:
        raise ParameterError(f"the vehicle '{car.name}' names no CAN database; give one with --dbc")
    paths = [shipped(each, ".dbc") for each in given]
    database = load_databases(paths)
    _refuse_unknown_ignition(ignition, database)
    used = channel_map or car.channel_map or _beside(paths)
    log, mcap, report, checkpoint, memory, baselines = files
    period, silence = times
    names = monitor or [each.name for each in MONITORS.values() if each.default is not None and not each.condition]
    plan = Plan(car, memory, baselines, shlex.join(["tierod", *sys.argv[1:]]))
    hub, inbox = Hub(), queue.SimpleQueue[Any]()
    outputs = Outputs(log, report, checkpoint, 5.0, silence, ignition, 64 if fd else 8, mcap)
    receivers = [receiver(number, each, inbox) for number, each in enumerate(addresses, 1)]
    if len(paths) > 1 and (text := disagreements({path: load_databases([path]) for path in paths})):
        print(f"tierod: {text}", file=sys.stderr)
    drive = Drive(receivers, inbox, database, loaded_map(used), names, plan, outputs, hub, Pace(period=period), origin)
    drive.health.traffic = Traffic(bitrate)
    mapped = ["--map", str(used)] if isinstance(used, str | Path) else []
    databases = [word for path in paths for word in ("--dbc", str(path))]
    drive.report_words = lambda path: [
        "diagnose", str(path), "--vehicle", vehicle, "--monitor", "all", *databases, *mapped,
        "-o", str(path.with_name(f"{path.stem}-{int(drive.engine.clock.latest)}s.html")),
    ]  # fmt: skip
    return drive, hub


def _refuse_unknown_ignition(ignition: str, database: Sequence[Message]) -> None:
    from tierod.core.errors import ParameterError, nearest

    known = [f"{message.name}.{signal.name}" for message in database for signal in message.signals]
    if ignition and ignition not in known:
        raise ParameterError(f"no database has the signal '{ignition}' of --ignition{nearest(ignition, known)}")


def _beside(paths: list[Path]) -> Any:
    from tierod.io.readers.channel_map import load_maps_beside, maps_beside

    found = maps_beside(paths)
    return load_maps_beside(found) if found else None


def _refuse_what_cannot_be_written(targets: list[Path | None], given: list[Path | None]) -> None:
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.files import require_folder

    for place, path in enumerate(targets):
        refuse_to_overwrite(path, [*given, *targets[:place]], "output", "its option")
        if path is not None:
            require_folder(path)


def _end_cleanly(drive: Drive) -> None:
    def end(*_: object) -> None:
        drive.ended = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)


def _followed(drive: Drive, drives: int, seconds: float, lines: bool) -> int:
    import time

    until = time.monotonic() + seconds if seconds > 0.0 else float("inf")

    def look(now: float) -> None:
        drive.ended |= now > until or bool(drives and drive.drives >= drives)

    drive.looking.append(look)
    if not lines:
        return _in_terminal(drive)
    drive.hub.add(lambda text: print(text, flush=True))
    return drive.run()


def _in_terminal(drive: Drive) -> int:
    from rich.live import Live

    from tierod.cli.terminal import output
    from tierod.live.view import keys, picture, pressed

    notes: list[str] = []
    drive.hub.add(lambda text: notes.append(text) if '"event": "state"' not in text else None)
    console, count = output(), [0]
    with keys(), Live(console=console, auto_refresh=False) as screen:

        def said() -> None:
            while notes:
                console.print(notes.pop(0), markup=False, soft_wrap=True)

        def look(now: float) -> None:
            count[0] += 1
            if count[0] % 10 == 0:
                _press(drive, pressed())
            if count[0] % 50 == 0:
                screen.update(picture(drive), refresh=True)
            said()

        drive.looking.append(look)
        code = drive.run()
        said()  # what became of the drive is said while it is closed
        return code


def _press(drive: Drive, key: str) -> None:
    if key == "m":
        drive.mark()
    elif key == "p":
        drive.paused = not drive.paused
    elif key == "r":
        _report_now(drive)
    elif key == "q":
        drive.ended = True


def _report_now(drive: Drive) -> None:
    """A page of the log so far, by a process of its own: the drive goes on meanwhile."""
    import subprocess

    log = drive.engine.log
    if log is None:
        drive.hub.say("problem", {"text": "a report of the drive so far is made from its log; begin with --log"})
        return
    words = drive.report_words(log.path)
    subprocess.Popen([sys.executable, "-m", "tierod", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    drive.hub.say("report", {"path": words[-1]})
