"""Cache of the graphs that earlier processes traced: a graph found here is neither traced nor printed again.

An entry is stored beside the compiled kernels, in the same verified files. Its name is a digest of the block's
structure, of every source file that a block may call, of the tracer and of the compiler; a class that is made at run
time enters as its maker and the arguments (`__made_by__`). It holds the names and shapes of the graph, or the name of
the kernel that was compiled from it. A block with a part that is not tierod's own has no entry: the digest does not
cover the sources of a plug-in. It does not cover what a script changes in a running process
either, such as a constant of a module; therefore only the command line uses entries, by the environment variable
TIEROD_GRAPHS.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Mapping
from enum import Enum
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Annotated, Any, get_args, get_origin

from tierod.core.graph import compiler

PACKAGE = Path(__file__).resolve().parents[2]
BLOCKS = ("core", "physics", "models", "methods", "monitors", "diagnosis")  # Packages whose blocks have entries

# Packages whose sources determine what a block computes: these, and those that they import
SOURCES = (*BLOCKS, "io", "vehicles")


class _Foreign(Exception): ...


def entry_of(structure: object, name: str) -> str | None:
    """Name of the entry of a graph; None for a block without one, or where entries are not used."""
    command = compiler.compiler()
    if command is None or os.environ.get("TIEROD_GRAPHS") != "known":
        return None
    try:
        return compiler.kernel_name(command, f"{_digest_of_sources()} {_text(structure)}", f"{name.lower()}_graph")
    except _Foreign:
        return None


def interface_of(entry: str) -> Mapping[str, Any] | None:
    """Names and shapes of a graph; None where no cache holds them."""
    kept = compiler.kept(entry)
    if kept is None:
        return None
    try:
        found: Mapping[str, Any] = pickle.loads(kept)
    except Exception:  # a class that was moved: the graph is traced again
        return None
    return found


def keep_interface(entry: str, interface: Mapping[str, Any]) -> None:
    """Keep names and shapes of a graph, where they can be serialised."""
    try:
        content = pickle.dumps(dict(interface))
    except Exception:  # a class that was made at run time cannot be imported by its name
        return
    compiler.keep(entry, content)


def kernel_entry(entry: str, kind: str) -> str:
    name, _, digest = entry.rpartition("-")
    return f"{name}_{kind}-{digest}"


def _text(part: object) -> str:
    if part is float:
        return "float"
    if not isinstance(part, tuple) or len(part) != 2 or not isinstance(part[0], type):
        raise _Foreign
    kind, value = part
    if kind in (int, bool, str, type(None)):
        return f"{kind.__name__} {value!r}"
    if isinstance(value, Enum):
        return f"{_address(kind)}.{value.name}"
    if isinstance(value, FunctionType | type):
        return f"{kind.__name__} {_address(value)}"
    if kind is tuple or type(value) is tuple:
        return f"{'tuple' if kind is tuple else _address(kind)}({', '.join(map(_text, value))})"
    raise _Foreign


def _address(what: Any) -> str:
    if "__made_by__" in vars(what):
        # A class that is made at run time is determined by the function that makes it and by the arguments.
        maker, given = what.__made_by__
        return f"{_address(maker)}({', '.join(map(_given, given))}) in {what.__module__}"
    package, _, rest = what.__module__.partition(".")
    found: Any = sys.modules.get(what.__module__)
    for name in what.__qualname__.split("."):
        found = getattr(found, name, None)
    if package != PACKAGE.name or rest.partition(".")[0] not in BLOCKS or found is not what:
        raise _Foreign
    return f"{what.__module__}.{what.__qualname__}"


def _given(argument: Any) -> str:
    """Argument from which a class is made, as text: a class, an annotation, a plain value, or a tuple of these."""
    if argument is Any or argument is float:
        return "Any" if argument is Any else "float"
    if get_origin(argument) in (Annotated, tuple):
        return f"{get_origin(argument)}[{', '.join(map(_given, get_args(argument)))}]"
    if isinstance(argument, tuple) and type(argument) is tuple:
        return f"({', '.join(map(_given, argument))})"
    if argument is None or type(argument) in (str, int, bool, float):
        return f"{type(argument).__name__} {argument!r}"
    if isinstance(argument, type):
        return _address(argument)
    raise _Foreign


@cache
def _digest_of_sources() -> str:
    digest = hashlib.sha256(sys.version.encode())
    for name in ("casadi", "numpy"):
        spec = find_spec(name)
        digest.update(compiler.identity(str(spec.origin if spec else "")).encode())
    for package in SOURCES:
        for path in sorted((PACKAGE / package).rglob("*")):
            if path.suffix in (".py", ".toml", ".c", ".csv"):
                digest.update(f"\0{path.relative_to(PACKAGE)}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()
