"""Digests of everything that determines a result: the content of data and the text of code."""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from tierod.core.files import sha256_of
from tierod.core.version import __version__

ROOT = Path(__file__).resolve().parents[1]

GROUND = ("proving_ground", "physics", "core")
"""Packages whose code determines a drive."""

TOWER = ("monitors", "methods", "models", "vehicles", "io")
"""Packages whose code determines a verdict, in addition to that of the drive."""

JUDGE = ("figures", "judged", "judging")
"""Modules of this package that compare a verdict with the true values."""


def fingerprint(*values: Any) -> str:
    """SHA-256 of values, in hexadecimal: equal for equal content in every process, whatever its hash seed.

    Args:
        values: dataclasses, mappings, sequences, arrays, sets, texts, numbers; a path contributes its name only, since
            its content is fingerprinted separately, as does a function, since `work_code` covers its code; fields
            excluded from comparisons are ignored

    Raises:
        TypeError: a value whose content is unknown, such as a function without a name
    """
    digest = hashlib.sha256()
    for part in _encoded(values):
        digest.update(part)
        digest.update(b"\0")
    return digest.hexdigest()


def _encoded(value: object) -> Iterator[bytes]:
    # Enums come first, since their members may be numbers or texts too.
    if isinstance(value, Enum):
        yield f"{type(value).__qualname__}.{value.name}".encode()
    elif value is None or isinstance(value, bool | int | str | bytes):
        yield f"{type(value).__name__} {value!r}".encode()
    elif isinstance(value, float):
        yield f"float {float(value).hex()}".encode()
    elif isinstance(value, np.ndarray | np.generic):
        array = np.asarray(value)
        yield f"array {array.dtype.str} {array.shape}".encode()
        yield np.ascontiguousarray(array).tobytes()
    elif isinstance(value, Path):
        yield f"path {value.name}".encode()
    elif dataclasses.is_dataclass(value):
        yield from _encoded_object(value)
    elif isinstance(value, Mapping):
        yield f"mapping {len(value)}".encode()
        for key in sorted(value, key=str):
            yield from _encoded(key)
            yield from _encoded(value[key])
    elif isinstance(value, list | tuple | set | frozenset):
        items: Iterable[Any] = sorted(value, key=repr) if isinstance(value, set | frozenset) else value
        yield f"{'named ' + type(value).__name__ if hasattr(value, '_fields') else 'sequence'} {len(value)}".encode()
        for item in items:
            yield from _encoded(item)
    elif isinstance(value, partial):
        yield from _encoded((value.func, value.args, value.keywords))
    elif isinstance(value, FunctionType) and "<" not in value.__qualname__:
        yield f"function {value.__module__}.{value.__qualname__}".encode()
    else:
        raise TypeError(f"no fingerprint of {value!r} ({type(value).__name__}): its content is not known")


def _encoded_object(value: Any) -> Iterator[bytes]:
    if isinstance(value, type):
        yield f"class {value.__module__}.{value.__qualname__}".encode()
        return
    yield f"dataclass {type(value).__qualname__}".encode()
    for field in filter(lambda each: each.compare, dataclasses.fields(value)):
        yield field.name.encode()
        yield from _encoded(getattr(value, field.name))


@cache
def ground_code() -> str:
    """Digest of what determines a drive besides its scenario: tierod's code, NumPy's version, the processor type."""
    return fingerprint(_contents(_files(GROUND)), __version__, np.__version__, platform.machine())


@cache
def tower_code() -> str:
    """Digest of the code that determines a verdict, in addition to that of the drive."""
    return fingerprint(_contents([*_files(TOWER), *(ROOT / "experiments" / f"{name}.py" for name in JUDGE)]))


@cache
def work_code(module: str) -> str:
    """Digest of the code that determines the results of a module: drives, methods, the module and its imports.

    Of the packages of studies only the files that the module imports directly or indirectly are included, so that a
    change of a claim or a chart leaves the drives of a study valid.

    Args:
        module: dotted name
    """
    files: set[Path] = set()
    waiting = [module]
    while waiting:
        path = _file_of(waiting.pop())
        if path is not None and path not in files:
            files.add(path)
            waiting += [name for name in _imports(path) if name.startswith(STUDIES) and " " not in name]
    return fingerprint(ground_code(), tower_code(), sorted(map(sha256_of, files)))


STUDIES = ("tierod_lab.papers.", "tierod_lab.campaign.", "tierod.fleet.")
"""Prefixes of the packages whose code belongs to studies."""


def _imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isprintable():
            yield node.value  # name of a module that is imported at run time


def _file_of(module: str) -> Path | None:
    """File of a module; None if the name is an object within a module."""
    try:
        found = find_spec(module)
    except (ModuleNotFoundError, ValueError):  # an object within a module, or a script
        return None
    return Path(found.origin) if found and found.origin else None


def _files(packages: Iterable[str]) -> list[Path]:
    return [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]


def _contents(paths: Iterable[Path]) -> dict[str, str]:
    return {path.relative_to(ROOT).as_posix(): sha256_of(path) for path in paths}
