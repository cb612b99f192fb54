"""List the shipped scenarios, virtual cars and courses, or show one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tierod.cli.terminal import output, print_json, rows, say
from tierod.core.shown import written

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tierod.core.toml_document import Document


def scenarios(
    name: Annotated[str | None, typer.Argument(help="A scenario, virtual car or course, or a scenario file.")] = None,
    cars: Annotated[bool, typer.Option("--cars", help="virtual cars alone; NAME may be their file")] = False,
    courses: Annotated[bool, typer.Option("--courses", help="courses alone; NAME may be their file")] = False,
    toml: Annotated[bool, typer.Option("--toml", help="print the file, to begin one of your own")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """List the scenarios, virtual cars and courses, or show one: car, course, sensors, faults, duration."""
    from tierod.core.errors import ParameterError

    for one, other, both in (("--cars", "--courses", cars and courses), ("--toml", "--json", toml and json)):
        if both:
            raise ParameterError(f"{one} and {other} exclude each other; give one of them")
    wanted = ("cars",) if cars else ("courses",) if courses else tuple(_kinds())
    if name is None:
        if toml:
            raise ParameterError("--toml needs the name of a scenario, car or course; 'tierod scenarios' lists them")
        _list(wanted, json)
        return
    kind = _kind_of(name, wanted)
    if toml:
        say(_to_begin_with(kind, name), end="")
    else:
        {"scenarios": _scenario, "cars": _car, "courses": _course}[kind](name, json)


def _kinds() -> dict[str, tuple[str, tuple[str, ...], Callable[[str], Path]]]:
    """Title, shipped names, and function that finds the file of a name, by kind."""
    from tierod_lab.ground import courses
    from tierod_lab.ground.cars import catalogue
    from tierod_lab.ground.scenarios import SCENARIOS

    return {
        "scenarios": ("scenario", tuple(SCENARIOS), SCENARIOS.find),
        "cars": ("virtual car", catalogue.shipped(), catalogue.find),
        "courses": ("course", courses.shipped(), courses.find),
    }


def _kind_of(name: str, wanted: tuple[str, ...]) -> str:
    from pathlib import Path

    from tierod.core.errors import ParameterError, nearest

    known = {kind: names for kind, (_, names, _) in _kinds().items() if kind in wanted}
    for kind, names in known.items():
        if name in names:
            return kind
    if name.lower().endswith((".toml", ".csv")) or Path(name).parent != Path():
        return wanted[0]
    what = "scenario, virtual car or course" if len(wanted) > 1 else _kinds()[wanted[0]][0]
    near = nearest(name, [each for names in known.values() for each in names])
    raise ParameterError(f"no {what} is called '{name}'{near} A file is named by its path")


def _document(kind: str, name: str) -> Document:
    from tierod.core.toml_document import Document

    return Document.read(_kinds()[kind][2](name), kind.removesuffix("s"))


def _to_begin_with(kind: str, name: str) -> str:
    from tierod_lab.ground.scenarios import named_files

    document = _document(kind, name)
    text, folder = document.text, document.path.parent.resolve()
    for each in named_files(document):
        text = text.replace(f'"{each}"', f'"{(folder / each).as_posix()}"')
    return text


def _list(kinds: tuple[str, ...], as_json: bool) -> None:
    known = _kinds()
    described = {k: [(n, str(_document(k, n).content["description"])) for n in known[k][1]] for k in kinds}
    if as_json:
        print_json({k: [{"name": n, "description": d} for n, d in rows] for k, rows in described.items()})
        return
    console = output()
    for kind, cells in described.items():
        console.print(rows((known[kind][0], "what it is"), cells))
        console.print()
    console.print(
        "Show one with 'tierod scenarios NAME', drive a scenario with 'tierod simulate NAME -o drive.mf4',\n"
        "begin your own with 'tierod scenarios NAME --toml > mine.toml'. Faults to add: 'tierod faults'."
    )


def _scenario(name: str, as_json: bool) -> None:
    from rich.text import Text

    from tierod_lab.ground.scenarios import load, plants

    found, console = load(name), output()
    if as_json:
        print_json(plants.scenario_document(found))
        return
    console.print(Text.assemble((found.name, "bold"), f": {found.description}\n"))
    console.print(rows(("", ""), plants.facts(found)))
    console.print(f"\nDrive it with 'tierod simulate {name} -o drive.mf4'.", markup=False)


def _car(name: str, as_json: bool) -> None:
    from rich.text import Text

    from tierod_lab.ground.cars import catalogue
    from tierod_lab.ground.scenarios import plants

    car, console = catalogue.load(name), output()
    document = plants.car_document(car)
    if as_json:
        print_json(document)
        return
    console.print(
        Text.assemble((document["name"], "bold"), f": {document['description']}"), Text(document["source"]), sep="\n"
    )
    for title, lines in (("Good for", document["good_for"]), ("Not good for", document["not_good_for"])):
        console.print(f"\n[bold]{title}[/bold]", *(Text(f"  - {line}") for line in lines), sep="\n")
    known = catalogue.choices(car.block)
    if car.vehicle:
        console.print(f"\nJudged as the vehicle '{car.vehicle}'; see 'tierod vehicles {car.vehicle}'.", markup=False)
    console.print()
    parts = [(place, part, ", ".join(known[place])) for place, part in document["parts"].items()]
    console.print(rows(("part", "is", "can be"), parts))
    console.print()
    cells = [
        (each["name"], f"{each['value']:.6g}", written(each["unit"]), each["source"]) for each in document["parameters"]
    ]
    console.print(rows(("parameter", "value", "unit", "source"), cells, right=(1,)))


def _course(name: str, as_json: bool) -> None:
    from rich.text import Text

    from tierod_lab.ground.courses import load
    from tierod_lab.ground.scenarios import plants

    document, console = plants.course_document(load(name)), output()
    if as_json:
        print_json(document)
        return
    console.print(Text.assemble((document["name"], "bold"), f": {document['description']}"))
    if document["source"]:
        console.print(Text(document["source"]))
    console.print(Text(f"\nA {document['kind']} of {document['duration']:.6g} s"))
    cells = [(each["name"], f"{each['value']:.6g}", written(each["unit"])) for each in document["parameters"]]
    if cells:
        console.print(rows(("parameter", "value", "unit"), cells, right=(1,)))
