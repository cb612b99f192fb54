"""Begin a vehicle file for your own car: typical values of its class, each with its standard deviation."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, NamedTuple

import typer


def new(
    file: Annotated[Path, typer.Argument(help="The vehicle file to write, for example car.toml.")],
    values: Annotated[
        list[str] | None,
        typer.Argument(help='What is known: mass=1480 wheelbase=2.68, mass=1480+-20, mass="1.48 t", front_share=0.6.'),
    ] = None,
    like: Annotated[
        str | None, typer.Option(help="A similar car: a name of 'tierod vehicles', or the path of a vehicle file.")
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option("--class", help="Class of the car: quadricycle, small, midsize, large, suv, van or race-car."),
    ] = None,
    channel_map: Annotated[
        Path | None,
        typer.Option("--map", help="Channel map that the file names; FILE.channels.toml beside it where there is one."),
    ] = None,
    dbc: Annotated[Path | None, typer.Option(help="CAN database of its bus, which the file names.")] = None,
    drive: Annotated[
        list[Path] | None, typer.Option(help="A recording of the car, named in the next commands; may be repeated.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a file that is there.")] = False,
) -> None:
    """Write a vehicle file with the given values, else typical ones, each with standard deviation and source."""
    from tierod.cli.terminal import output
    from tierod.core.errors import OutputError, ParameterError
    from tierod.core.files import require_folder, write_text
    from tierod.vehicles import QUANTITIES, load
    from tierod.vehicles.writer import begun, known_from, text_of

    if file.suffix != ".toml" or "=" in file.name:
        raise OutputError(
            f"{file} is not the name of a vehicle file, which ends in .toml; write 'tierod new car.toml ...'"
        )
    require_folder(file)
    if file.exists() and not overwrite:
        raise OutputError(f"{file} exists already; name another file, or replace it with --overwrite")
    known = known_from(values or [])
    car = None if like is None else load(like)
    found, parameters = begun(known, kind, car)
    named, counts = _map_for(file, channel_map)
    if dbc is not None and not dbc.is_file():
        raise ParameterError(f"there is no CAN database {dbc}; check the path, or leave it out")
    bus = None if dbc is None else _from(file, dbc)
    given = [name for name in known if name in QUANTITIES and QUANTITIES[name].torque]
    if counts and given:
        raise ParameterError(
            f"the channel map reads torques as raw counts, so {given[0]} in N*m has no meaning; leave it out"
        )
    write_text(file, text_of(file.stem, found, parameters, named, None if car is None else car.name, counts, bus))
    console = output()
    for line in _said(file, found, len(known), len(load(file).parameters), named, drive or []):
        console.print(line, markup=False, soft_wrap=True)


def _map_for(file: Path, channel_map: Path | None) -> tuple[str | None, bool]:
    from tierod.core.units import COUNT
    from tierod.io.readers import load_channel_map

    beside = file.with_name(f"{file.stem}.channels.toml")
    if channel_map is None and not beside.is_file():
        return None, False
    chosen = channel_map or beside
    entries = load_channel_map(chosen).entries
    counts = any(entries[name].unit == COUNT for name in ("driver_torque", "motor_torque") if name in entries)
    return _from(file, chosen), counts


def _from(file: Path, other: Path) -> str:
    import os

    return Path(os.path.relpath(other.resolve(), file.parent.resolve())).as_posix()


def _said(file: Path, kind: str, given: int, total: int, channel_map: str | None, drives: Sequence[Path]) -> list[str]:
    lines = [
        f"vehicle file: {file}: class {kind}, {given} values given, {total} parameters, each with its spread",
        "replace values that you know better, and give each its standard deviation",
    ]
    if channel_map is not None:
        lines.append(f"channel map: {channel_map}")
    return [*lines, *next_commands(file, drives)]


def next_commands(file: Path, drives: Sequence[Path]) -> list[str]:
    looked_at = [_Use.of(each, file) for each in drives]
    car = shlex.quote(str(file))
    learn = shlex.join(str(each.path) for each in looked_at if not each.not_learnt) or ("" if drives else "DRIVE")
    judge = shlex.join(str(each.path) for each in looked_at if each.judged) or ("" if drives else "DRIVE")
    lines = [f"go on with: tierod identify vehicle {learn} --vehicle {car} --output {car}"] if learn else []
    if judge:
        lines.append(f"{'or judge at once' if learn else 'go on with'}: tierod diagnose {judge} --vehicle {car}")
    useless = [each.path for each in looked_at if each.not_learnt and not each.judged]
    lines += [f"see what it lacks: tierod inspect {shlex.quote(str(each))} --vehicle {car}" for each in useless]
    return [*lines, *(f"identify would refuse it: {each.not_learnt}" for each in looked_at if each.not_learnt)]


class _Use(NamedTuple):
    """Possible uses of a recording of a car."""

    path: Path
    not_learnt: str  # why parameters cannot be identified from it; "" if they may be
    judged: bool  # whether a monitor can judge it

    @classmethod
    def of(cls, path: Path, file: Path) -> _Use:
        """Uses of a recording for the car of a vehicle file; every use if it does not exist yet, or is a pipe."""
        from tierod.cli.terminal import progress
        from tierod.core.errors import TierodError
        from tierod.io.readers import read
        from tierod.methods.identification.drives import SIGNALS, drive_of
        from tierod.monitors.diagnose import able
        from tierod.vehicles import load
        from tierod.vehicles.vehicle import read_by

        if not path.exists() or path.is_fifo():
            return cls(path, "", True)
        car, reason, judged = load(file), "", False
        databases, used = read_by(car)
        with progress(f"reading {path.name}"):
            try:
                drive_of(path.name, read(path, dbc=databases, channel_map=used, names=SIGNALS))
            except TierodError as error:
                reason = " ".join(str(error).split())
            with suppress(TierodError):
                judged = any(able(path, car))
        return cls(path, reason, judged)
