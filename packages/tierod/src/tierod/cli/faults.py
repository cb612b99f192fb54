"""Faults: those that can be injected into a simulation, and those that a fault memory holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import output, print_json, print_remark, show
from tierod.core.errors import InputError, ParameterError
from tierod.core.plugins import part

if TYPE_CHECKING:
    from tierod.diagnosis.fault_memory import FaultMemory


MEMORY_VERBS = ("read", "clear", "snapshot")


def faults(
    name: Annotated[
        str | None,
        typer.Argument(help="a shipped fault, or the path of a fault file; or: read, clear, snapshot (of a memory)"),
    ] = None,
    memory: Annotated[Path | None, typer.Argument(help="with read, clear, snapshot: the file of the memory")] = None,
    code: Annotated[
        str | None, typer.Argument(help="with snapshot, optional with read and clear: a trouble code or its name")
    ] = None,
    uds: Annotated[
        str | None, typer.Option("--uds", help="with read: answer a UDS request in hexadecimal digits, such as 1902FF")
    ] = None,
    behaviours: Annotated[
        bool, typer.Option("--behaviours", help="list the behaviours of faulty elements instead")
    ] = False,
    toml: Annotated[bool, typer.Option("--toml", help="print the file, to begin one of your own")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """List the known faults, or show one; read or clear a fault memory, or show a freeze frame of it.

    tierod faults                            the faults that can be injected into a simulation
    tierod faults read memory.json           the trouble codes that a memory holds
    tierod faults snapshot memory.json CODE  the signals around the instant at which a test failed
    tierod faults clear memory.json          clear all codes, or the one given
    """
    if name in MEMORY_VERBS:
        if toml or behaviours:
            raise ParameterError(f"--toml and --behaviours have no meaning with '{name}'; leave them out")
        on_memory(str(name), memory, code, uds, json)
        return
    if memory is not None or uds is not None:
        raise ParameterError(
            f"a memory or --uds needs one of {', '.join(MEMORY_VERBS)}, not '{name}'; name one of them"
        )
    part("faults", "a fault that can be injected")(name, behaviours, toml, json)


def on_memory(verb: str, path: Path | None, code: str | None, uds: str | None, json: bool) -> None:
    if path is None:
        raise ParameterError(f"'tierod faults {verb}' needs the file of a memory: tierod faults {verb} memory.json")
    if uds is not None and (verb != "read" or code is not None or json):
        raise ParameterError("--uds works with 'read' and a memory only; leave the rest out")
    {"read": _read, "clear": _clear, "snapshot": _snapshot}[verb](path, code, uds, json)


def _opened(path: Path) -> FaultMemory:
    from tierod.diagnosis.fault_memory import FaultMemory

    if not path.exists():
        raise InputError(f"there is no fault memory {path}; 'tierod diagnose --memory {path}' begins one")
    return FaultMemory.opened(path)


def _read(path: Path, code: str | None, uds: str | None, json: bool) -> None:
    from tierod.diagnosis.uds import answer

    memory = _opened(path)
    if uds is not None:
        print(
            answer(memory, _request(uds)).hex(" ").upper() or "no answer: the request suppresses the positive response"
        )
    elif json or code is not None:
        stored = [each for each, entry in memory.entries.items() if entry.stored]
        print_json({"codes": [_code(memory, each) for each in stored]} if code is None else _code(memory, code))
    else:
        from tierod.report.terminal import memory_items

        show(memory_items(memory))


def _code(memory: FaultMemory, name_or_code: str) -> dict[str, Any]:
    """A stored trouble code with its status, its history and its freeze frames."""
    name = memory.codes.named(name_or_code)
    code, entry = memory.codes.codes[name], memory.entries[name]
    if not entry.stored:
        raise ParameterError(
            f"the memory has no entry of {code.code} ({name}): it has not failed since it was cleared, has aged out, "
            "or was replaced by another"
        )
    stated = {"code": code.code, "name": name, "meaning": code.meaning, "severity": code.severity}
    return {**stated, **entry.document(), "status": entry.status.words, "byte": f"{int(entry.status):02X}"}


def _request(digits: str) -> bytes:
    try:
        request = bytes.fromhex(digits)
    except ValueError:
        raise ParameterError(f"--uds is '{digits}'; expected pairs of hexadecimal digits, as 1902FF") from None
    if not request or request[0] != 0x19:
        raise ParameterError(f"--uds is '{digits}'; expected a request of service 19; clear with 'tierod faults clear'")
    return request


def _snapshot(path: Path, code: str | None, uds: str | None, json: bool) -> None:
    from tierod.report.terminal import snapshot_items

    if code is None:
        raise ParameterError(
            f"name a trouble code: tierod faults snapshot {path} CODE; 'tierod faults read' lists them"
        )
    memory = _opened(path)
    content = _code(memory, code)
    if json:
        print_json({each: content[each] for each in ("code", "name", "first", "last")})
        return
    entry = memory.entries[content["name"]]
    frames = {"first failure": entry.first, "latest failure": entry.last}
    if entry.first == entry.last:
        del frames["latest failure"]
    for which, frame in frames.items():
        if frame is None:
            output().print(f"The test failed ({which}), but no signals were kept.")
        else:
            show(snapshot_items(frame, which))


def _clear(path: Path, code: str | None, uds: str | None, json: bool) -> None:
    from tierod.core.files import holding
    from tierod.diagnosis import store
    from tierod.diagnosis.fault_memory import FaultMemory

    if not path.exists():
        raise InputError(f"there is no fault memory {path}; there is nothing to clear")
    try:
        with FaultMemory.changing(path) as memory:
            if code is not None:
                memory.codes.named(code)
            kept = store.aside(path)
            memory.clear(code)
    except InputError:
        if code is not None:
            raise
        with holding(path) as target:
            kept = store.remove(target)
    print_remark(f"cleared {path}; its previous content is kept as {kept}")
    if json:
        print_json({"cleared": str(path), "kept": str(kept)})
