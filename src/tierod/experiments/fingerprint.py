"""What decides a result, as one number: data by their content, code by its text."""

from __future__ import annotations

import dataclasses
import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tierod import __version__

ROOT = Path(__file__).resolve().parents[1]

GROUND = ("proving_ground", "physics", "core")
"""Packages whose code decides a drive."""

TOWER = ("monitors", "methods", "models", "vehicles", "io")
"""Packages whose code decides a verdict beyond the drive."""

JUDGE = ("alarms", "figures", "judged", "judging")
"""Files of this package that hold a verdict against the truth."""


def fingerprint(*values: Any) -> str:
    """The SHA-256 of values, in hexadecimal: equal for equal content, whatever the process and its hash seed.

    Args:
        values: dataclasses, mappings, sequences, arrays, sets, texts, numbers; a path counts by its name alone, since
            what was read from it stands beside it; fields that do not count in comparisons do not count here

    Raises:
        TypeError: something of which the content is not known, such as a function
    """
    digest = hashlib.sha256()
    for part in _told(values):
        digest.update(part)
        digest.update(b"\0")
    return digest.hexdigest()


def _told(value: Any) -> Iterator[bytes]:
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
        yield from _told_of_class(value)
    elif isinstance(value, Mapping):
        yield f"mapping {len(value)}".encode()
        for key in sorted(value, key=str):
            yield from _told(key)
            yield from _told(value[key])
    elif isinstance(value, list | tuple | set | frozenset):
        items: Iterable[Any] = sorted(value, key=repr) if isinstance(value, set | frozenset) else value
        yield f"{'named ' + type(value).__name__ if hasattr(value, '_fields') else 'sequence'} {len(value)}".encode()
        for item in items:
            yield from _told(item)
    else:
        raise TypeError(f"no fingerprint of {value!r} ({type(value).__name__}): its content is not known")


def _told_of_class(value: Any) -> Iterator[bytes]:
    if isinstance(value, type):
        yield f"class {value.__module__}.{value.__qualname__}".encode()
        return
    yield f"dataclass {type(value).__qualname__}".encode()
    for field in filter(lambda each: each.compare, dataclasses.fields(value)):
        yield field.name.encode()
        yield from _told(getattr(value, field.name))


@cache
def ground_code() -> str:
    """Of all that decides a drive beside its scenario: tierod's code, NumPy's random numbers, the kind of processor."""
    return fingerprint(_contents(_files(GROUND)), __version__, np.__version__, platform.machine())


@cache
def tower_code() -> str:
    """Of all code that decides a verdict beyond the drive."""
    return fingerprint(_contents([*_files(TOWER), *(ROOT / "experiments" / f"{name}.py" for name in JUDGE)]))


def _files(packages: Iterable[str]) -> list[Path]:
    return [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]


def _contents(paths: Iterable[Path]) -> dict[str, str]:
    return {path.relative_to(ROOT).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}
