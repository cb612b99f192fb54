"""What `tierod faults` does with a fault memory: read, clear, snapshot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tierod.cli.terminal import messages, output, print_json
from tierod.core.errors import InputError, ParameterError

if TYPE_CHECKING:
    from tierod.diagnosis.fault_memory import FaultMemory


def on_memory(verb: str, path: Path | None, code: str | None, uds: str | None, json: bool) -> None:
    """Do what a verb asks for.

    Args:
        verb: read, clear or snapshot
        path: of the memory's file
        code: a trouble code or its name
        uds: request in hexadecimal digits, with read
        json: whether one JSON document is printed

    Raises:
        ParameterError: no path, no such code, or arguments that do not go together
        InputError: the file cannot be read
        OutputError: it cannot be written
    """
    if path is None:
        raise ParameterError(f"'tierod faults {verb}' needs the file of a memory: tierod faults {verb} memory.json")
    if uds is not None and (verb != "read" or code is not None or json):
        raise ParameterError("--uds goes with 'read' and a memory alone; leave the rest out")
    {"read": _read, "clear": _clear, "snapshot": _snapshot}[verb](path, code, uds, json)


def _opened(path: Path) -> FaultMemory:
    """The memory in a file, whoever's it is, as it stands there."""
    from tierod.diagnosis.fault_memory import FaultMemory

    if not path.exists():
        raise InputError(f"there is no fault memory {path}; 'tierod diagnose --memory {path}' begins one")
    return FaultMemory.opened(path)


def _read(path: Path, code: str | None, uds: str | None, json: bool) -> None:
    from tierod.diagnosis import sovd
    from tierod.diagnosis.uds import answer

    memory = _opened(path)
    if uds is not None:
        print(answer(memory, _request(uds)).hex(" ").upper() or "no answer: the request suppresses a positive one")
    elif json or code is not None:
        print_json(sovd.faults(memory) if code is None else sovd.fault(memory, code))
    else:
        from tierod.report.fault_memory import print_memory

        print_memory(memory, output())


def _request(digits: str) -> bytes:
    try:
        request = bytes.fromhex(digits)
    except ValueError:
        raise ParameterError(f"--uds is '{digits}'; expected pairs of hexadecimal digits, as 1902FF") from None
    if not request or request[0] != 0x19:
        raise ParameterError(f"--uds is '{digits}'; expected a request of service 19; clear with 'tierod faults clear'")
    return request


def _snapshot(path: Path, code: str | None, uds: str | None, json: bool) -> None:
    from tierod.diagnosis import sovd
    from tierod.report.fault_memory import print_snapshot

    if code is None:
        raise ParameterError(
            f"name a trouble code: tierod faults snapshot {path} CODE; 'tierod faults read' lists them"
        )
    memory = _opened(path)
    told = sovd.fault(memory, code)
    entry = memory.entries[memory.codes.named(code)]
    if json:
        print_json(told["environment_data"])
        return
    frames = {"first failure": entry.first, "latest failure": entry.last}
    if entry.first == entry.last:
        del frames["latest failure"]
    for which, frame in frames.items():
        if frame is None:
            output().print(f"The test failed ({which}), but no signals were kept.")
        else:
            print_snapshot(frame, which, output())


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
    messages().print(f"cleared {path}; what it held is kept as {kept}", soft_wrap=True, markup=False)
    if json:
        print_json({"cleared": str(path), "kept": str(kept)})
