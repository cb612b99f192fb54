"""List the known vehicles, or show one with the source of every value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import output, print_json, rows, say
from tierod.core.shown import written

if TYPE_CHECKING:
    from tierod.vehicles import Vehicle


def vehicles(
    name: Annotated[str | None, typer.Argument(help="a shipped vehicle, or the path of a vehicle file")] = None,
    toml: Annotated[bool, typer.Option("--toml", help="print the file, to begin one of your own")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """List the shipped vehicles, or show one: values, units, spread, sources, and what it is not suitable for."""
    from tierod.core.errors import ParameterError
    from tierod.vehicles import VEHICLES, load

    if toml and json:
        raise ParameterError("--toml and --json exclude each other; give one of them")
    if toml and name is None:
        raise ParameterError(f"--toml needs a vehicle: {', '.join(VEHICLES)}")
    if name is None:
        found = [load(each) for each in VEHICLES]
        print_json({"vehicles": [_document(each) for each in found]}) if json else _list(found)
        return
    vehicle = load(name)
    if toml:
        say(_to_begin_with(vehicle), end="")
    elif json:
        print_json(_document(vehicle))
    else:
        _show(vehicle)


def _to_begin_with(vehicle: Vehicle) -> str:
    """Text of the file; files that it names are found beside a copy or among the shipped ones."""
    from tierod.core.errors import ParameterError
    from tierod.core.user_files import read_text

    return read_text(vehicle.path, "the vehicle file", ParameterError)


def _document(vehicle: Vehicle) -> dict[str, Any]:
    columns = ("name", "value", "unit", "standard_deviation", "source")
    return {
        "name": vehicle.name,
        "description": vehicle.description,
        "source": vehicle.source,
        "good_for": list(vehicle.good_for),
        "not_good_for": list(vehicle.not_good_for),
        "torque_unit": vehicle.torque_unit,
        "parameters": [dict(zip(columns, row, strict=True)) for row in vehicle.rows()],
    }


def _list(found: list[Vehicle]) -> None:
    console = output()
    console.print(
        rows(("vehicle", "what it is", "torques in"), [(v.name, v.description, written(v.torque_unit)) for v in found])
    )
    console.print(
        "\nShow one with 'tierod vehicles NAME'; begin your own with 'tierod vehicles NAME --toml > car.toml'."
    )


def _show(vehicle: Vehicle) -> None:
    from rich.text import Text

    console = output()
    console.print(Text.assemble((vehicle.name, "bold"), f": {vehicle.description}"), Text(vehicle.source), sep="\n")
    for title, lines in (("Good for", vehicle.good_for), ("Not good for", vehicle.not_good_for)):
        console.print(f"\n[bold]{title}[/bold]", *(Text(f"  - {line}") for line in lines), sep="\n")
    cells = [
        (name, f"{value:.6g}", "" if spread is None else f"{spread:.6g}", written(unit), source)
        for name, value, unit, spread, source in vehicle.rows()
    ]
    console.print()
    console.print(rows(("parameter", "value", "+-", "unit", "source"), cells, right=(1, 2)))
