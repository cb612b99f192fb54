"""The faults that can be injected into a simulation, and the behaviours of faulty elements."""

from __future__ import annotations

from typing import Any

from tierod.cli.terminal import output, print_json, rows, say
from tierod.core.errors import ParameterError
from tierod.core.user_files import read_text
from tierod_lab.ground.faults import FAULTS, FaultFile, load


def injectable(name: str | None, behaviours: bool, toml: bool, json: bool) -> None:
    """List the shipped faults or the behaviours, or show a fault."""
    if toml and json:
        raise ParameterError("--toml and --json exclude each other; give one of them")
    if toml and name is None:
        raise ParameterError("--toml needs a fault; 'tierod faults' lists them")
    if behaviours:
        if name is not None:
            raise ParameterError(f"--behaviours lists all of them; leave '{name}' out")
        _behaviours(json)
    elif name is None:
        found = [load(each) for each in FAULTS]
        print_json({"faults": [_document(each) for each in found]}) if json else _list(found)
    elif toml:
        say(read_text(load(name).path, "the fault file", ParameterError), end="")
    elif json:
        print_json(_document(load(name)))
    else:
        _show(load(name))


def _document(file: FaultFile) -> dict[str, Any]:
    from tierod_lab.ground.faults.behaviours import described
    from tierod_lab.ground.faults.fault import trigger_table

    fault = file.fault
    return {
        "name": file.name,
        "description": file.description,
        "source": file.source,
        "effects": [{"element": each.element, "behaviour": described(each.behaviour)} for each in fault.effects],
        "trigger": trigger_table(fault.trigger),
        "duration": fault.lasts,
    }


def _list(found: list[FaultFile]) -> None:
    console = output()
    console.print(rows(("fault", "what happens"), [(each.name, each.description) for each in found]))
    console.print(
        "\nShow one with 'tierod faults NAME'; begin your own with 'tierod faults NAME --toml > fault.toml'.\n"
        "How elements can behave is listed by 'tierod faults --behaviours'."
    )


def _show(file: FaultFile) -> None:
    from rich.text import Text

    from tierod_lab.ground.faults import reading

    console, fault = output(), file.fault
    console.print(Text.assemble((file.name, "bold"), f": {file.description}"), Text(file.source), sep="\n")
    console.print()
    console.print(rows(("element", "behaviour"), [(each.element, reading.of_effect(each)) for each in fault.effects]))
    console.print(Text(f"\nBegins {reading.of_beginning(fault)}, lasts {reading.of_duration(fault)}."))
    use = f'use = "{file.name if file.name in FAULTS else file.path}"'
    console.print(Text(f"\nIn a scenario; element, behaviour, size, start, duration may follow:\n[[faults]]\n{use}"))


def _behaviours(json: bool) -> None:
    from tierod_lab.ground.faults import BEHAVIOURS, reading

    cells = []
    for name, kind in sorted(BEHAVIOURS.items()):
        first = (kind.__doc__ or "").strip().split("\n\n")[0]
        cells.append((name, " ".join(first.split()), reading.of_fields(kind), ", ".join(sorted(kind.fits)) or "any"))
    if json:
        titles = ("name", "description", "fields", "elements")
        print_json({"behaviours": [dict(zip(titles, row, strict=True)) for row in cells]})
        return
    output().print(rows(("behaviour", "what it does", "takes", "fits"), cells))
