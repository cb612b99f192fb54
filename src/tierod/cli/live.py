"""Follow live buses: verdicts while driving, a log that survives a kill, fault memory and report at the end."""

from __future__ import annotations

import contextlib
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tierod.live.drive import Drive
    from tierod.live.events import Hub, Socket


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
    log: Annotated[Path | None, typer.Option(help="MF4 file to which every frame is logged.")] = None,
    memory: Annotated[Path | None, typer.Option(help="Fault memory; every drive is one operation cycle.")] = None,
    report: Annotated[Path | None, typer.Option(help="HTML page at the end of the drive.")] = None,
    baselines: Annotated[Path | None, typer.Option(help="Folder with the baseline that each monitor learnt.")] = None,
    bitrate: Annotated[int | None, typer.Option(help="Bit rate [bit/s]; that of the driver if not given.")] = None,
    fd: Annotated[bool, typer.Option("--fd", help="Receive frames of CAN FD.")] = False,
    interface_option: Annotated[
        list[str] | None, typer.Option(help="NAME=VALUE for python-can, N:NAME=VALUE for the N-th bus alone.")
    ] = None,
    period: Annotated[float, typer.Option(help="Length of the pieces in which the drive is judged [s].")] = 0.5,
    silence: Annotated[float, typer.Option(help="Time without a frame after which the drive has ended [s].")] = 30.0,
    ignition: Annotated[
        str, typer.Option(help='Signal of a database, as "Message.Signal", whose value 0 ends the drive.')
    ] = "",
    drives: Annotated[int, typer.Option(help="End after this many drives; 0: no limit.")] = 0,
    seconds: Annotated[float, typer.Option(help="End after this time [s]; 0: run until Ctrl-C.")] = 0.0,
    websocket: Annotated[int | None, typer.Option(help="Local port for the events; 0: any free port.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Events as JSON lines, as without a terminal.")] = False,
) -> int:
    """Follow live buses until Ctrl-C: healthy (0), fault (1), could not judge (2), bad input (3)."""
    from tierod.cli.live_setup import Wanted, drive_of, refuse_unfit
    from tierod.live.buses import Address
    from tierod.live.options import interface_options

    wanted = Wanted(
        vehicle, tuple(dbc or ()), channel_map, tuple(monitor or ()), log, report, memory, baselines,
        period, silence, ignition, fd, bitrate,
    )  # fmt: skip
    refuse_unfit(wanted)
    options = interface_options(interface_option or [], len(channel))
    addresses = [Address(interface, each, bitrate, fd, own) for each, own in zip(channel, options, strict=True)]
    drive, hub = drive_of(wanted, addresses)
    with contextlib.ExitStack() as stack:
        if websocket is not None:
            stack.callback(_socket(hub, websocket).close)
        return _followed(drive, drives, seconds, as_json or not sys.stdout.isatty())


def _socket(hub: Hub, port: int) -> Socket:
    """Start a server that sends the events to every client that connects to the port."""
    from tierod.live.events import Socket

    socket = Socket(port)
    hub.add(socket)
    print(f"events: ws://127.0.0.1:{socket.port}", file=sys.stderr)
    return socket


def _end_cleanly(drive: Drive) -> None:
    def end(*_: object) -> None:
        drive.ended = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)


def _followed(drive: Drive, drives: int, seconds: float, lines: bool) -> int:
    import time

    _end_cleanly(drive)
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
        said()  # results of the drive are reported while it is closed
        return code


def _press(drive: Drive, key: str) -> None:
    if key == "m":
        drive.mark()
    elif key == "p":
        drive.paused = not drive.paused
    elif key == "q":
        drive.ended = True
