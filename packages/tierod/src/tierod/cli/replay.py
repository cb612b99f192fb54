"""Play a recording onto a bus: its frames, or its signals encoded by a DBC; with seeded disturbances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tierod.live.clock import Frame
    from tierod.live.encoding import Differences
    from tierod.live.replay import Played


def replay(
    recording: Annotated[Path, typer.Argument(help="Bus log, or a recording whose signals a DBC encodes.")],
    interface: Annotated[str, typer.Option(help="Interface of python-can: socketcan, udp_multicast, ...")],
    channel: Annotated[list[str], typer.Option(help="Channel of the interface; once for every bus.")],
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: signal of the DBC for each canonical signal.")
    ] = None,
    interface_option: Annotated[
        list[str] | None, typer.Option(help="NAME=VALUE for python-can, N:NAME=VALUE for the N-th bus alone.")
    ] = None,
    fd: Annotated[bool, typer.Option("--fd", help="Open buses of CAN FD.")] = False,
    speed: Annotated[float, typer.Option(help="Multiple of real time; 0: as fast as the bus accepts.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of the disturbances.")] = 0,
    loss: Annotated[float, typer.Option(help="Share of frames that are lost.")] = 0.0,
    doubled: Annotated[float, typer.Option(help="Share of frames that are sent twice.")] = 0.0,
    jitter: Annotated[float, typer.Option(help="Standard deviation of a delay [s].")] = 0.0,
    reordered: Annotated[float, typer.Option(help="Share of frames that are held back by 20 ms.")] = 0.0,
    bus_off: Annotated[float, typer.Option(help="Bus-offs per minute, of half a second each.")] = 0.0,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> None:
    """Play a recording onto a bus until its end or Ctrl-C."""
    from tierod.cli.terminal import print_remark
    from tierod.io.readers.dbc import load_databases
    from tierod.io.readers.opening import shipped
    from tierod.io.readers.reading import loaded_map
    from tierod.live.buses import Address, interface_options, open_bus
    from tierod.live.encoding import Differences
    from tierod.live.replay import Disturbance, Played, disturbed, frames_of_file, play

    _require_ranges(
        {"--loss": loss, "--doubled": doubled, "--reordered": reordered},
        {"--speed": speed, "--jitter": jitter, "--bus-off": bus_off},
    )
    options = interface_options(interface_option or [], len(channel))
    database = load_databases([shipped(each, ".dbc") for each in dbc]) if dbc else []
    differences = Differences()
    found = frames_of_file(recording, database, loaded_map(channel_map), differences)
    frames = _with_a_first(found, recording, differences)
    addresses = [Address(interface, each, None, fd, own) for each, own in zip(channel, options, strict=True)]
    buses, played = [open_bus(each) for each in addresses], Played()
    try:
        print_remark(f"playing {recording} onto {interface} {' '.join(channel)}")
        play(
            disturbed(frames, Disturbance(seed, loss, doubled, jitter, reordered, bus_off), played),
            buses,
            speed,
            played,
            say=print_remark,
        )
    finally:
        for bus in buses:
            bus.shutdown()
    for sentence in differences.sentences():
        print_remark(sentence)
    _print(played, as_json)


def _require_ranges(shares: Mapping[str, float], amounts: Mapping[str, float]) -> None:
    """Refuse options outside their range: shares from 0 to 1, amounts from 0 on."""
    from tierod.core.errors import ParameterError

    for name, value in shares.items():
        if not 0.0 <= value <= 1.0:
            raise ParameterError(f"{name} is a share between 0 and 1, not {value:g}")
    for name, value in amounts.items():
        if not 0.0 <= value < float("inf"):
            raise ParameterError(f"{name} needs a number from 0 on, not {value:g}")


def _with_a_first(frames: Iterator[Frame], recording: Path, differences: Differences) -> Iterator[Frame]:
    """The frames, of which the first is read at once: an unreadable recording is refused before a bus is opened."""
    import itertools

    from tierod.core.errors import InputError

    first = next(frames, None)
    if first is None:
        why = "; ".join(differences.sentences()) or "it holds no frame"
        raise InputError(f"{recording}: nothing can be sent: {why}; give a recording that has the signals at one time")
    return itertools.chain([first], frames)


def _print(played: Played, as_json: bool) -> None:
    import dataclasses

    from tierod.cli.terminal import output, print_json

    if as_json:
        print_json(dataclasses.asdict(played))
        return
    output().print(
        f"{played.sent} frames sent, {played.lost} lost, {played.doubled} doubled, {played.held} held back, "
        f"{played.off} bus-offs, {played.failed} refused by the bus",
        soft_wrap=True,
        markup=False,
    )
