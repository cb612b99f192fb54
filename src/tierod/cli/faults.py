"""Faults: those that can be injected into a simulation, and those that a fault memory holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import output, print_json, rows
from tierod.cli.visible import say
from tierod.core.errors import ParameterError
from tierod.core.user_files import read_text

if TYPE_CHECKING:
    from tierod.proving_ground.faults import FaultFile

MEMORY_VERBS = ("read", "clear", "snapshot")


def faults(
    name: Annotated[
        str | None,
        typer.Argument(help="a shipped fault, or the path of a fault file; or: read, clear, snapshot (of a memory)"),
    ] = None,
    memory: Annotated[Path | None, typer.Argument(help="with read, clear, snapshot: the file of the memory")] = None,
    code: Annotated[
        str | None, typer.Argument(help="with snapshot, and if wished with read and clear: a trouble code or its name")
    ] = None,
    uds: Annotated[
        str | None, typer.Option("--uds", help="with read: answer a request in hexadecimal digits, as 1902FF")
    ] = None,
    behaviours: Annotated[bool, typer.Option("--behaviours", help="list how elements can behave instead")] = False,
    toml: Annotated[bool, typer.Option("--toml", help="print the file, to begin one of your own")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """List the faults that are known, or show one; read, clear a fault memory, or show a freeze frame of it.

    tierod faults                            the faults that can be injected into a simulation
    tierod faults read memory.json           the trouble codes that a memory holds
    tierod faults snapshot memory.json CODE  the signals around the instant at which a test failed
    tierod faults clear memory.json          forget all codes, or the one given
    """
    if name in MEMORY_VERBS:
        from tierod.cli.fault_memory import on_memory

        if toml or behaviours:
            raise ParameterError(f"--toml and --behaviours have no meaning with '{name}'; leave them out")
        on_memory(str(name), memory, code, uds, json)
        return
    if memory is not None or uds is not None:
        raise ParameterError(f"a memory is given, but '{name}' is none of {', '.join(MEMORY_VERBS)}; name one of them")
    from tierod.proving_ground.faults import FAULTS, load

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
    from tierod.proving_ground.faults import triggers
    from tierod.proving_ground.faults.behaviours import described

    fault = file.fault
    return {
        "name": file.name,
        "description": file.description,
        "source": file.source,
        "effects": [{"element": each.element, "behaviour": described(each.behaviour)} for each in fault.effects],
        "trigger": triggers.described(fault.trigger),
        "duration": fault.duration or fault.behaviour.usual_duration,
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

    from tierod.proving_ground.faults import FAULTS, wording

    console, fault = output(), file.fault
    console.print(Text.assemble((file.name, "bold"), f": {file.description}"), Text(file.source), sep="\n")
    console.print()
    console.print(rows(("element", "behaviour"), [(each.element, wording.of_effect(each)) for each in fault.effects]))
    console.print(Text(f"\nBegins {wording.of_beginning(fault)}, lasts {wording.of_duration(fault)}."))
    use = f'use = "{file.name if file.name in FAULTS else file.path}"'
    console.print(Text(f"\nIn a scenario; element, behaviour, size, start, duration may follow:\n[[faults]]\n{use}"))


def _behaviours(json: bool) -> None:
    from tierod.proving_ground.faults import BEHAVIOURS, wording

    cells = []
    for name, kind in sorted(BEHAVIOURS.items()):
        first = (kind.__doc__ or "").strip().split("\n\n")[0]
        cells.append((name, " ".join(first.split()), wording.of_fields(kind), ", ".join(sorted(kind.fits)) or "any"))
    if json:
        titles = ("name", "description", "fields", "elements")
        print_json({"behaviours": [dict(zip(titles, row, strict=True)) for row in cells]})
        return
    output().print(rows(("behaviour", "what it does", "takes", "fits"), cells))
