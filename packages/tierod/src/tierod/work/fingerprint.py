"""Digests of everything that determines a result: the content of data and the text of code."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from tierod.core import plugins as lab
from tierod.core.files import sha256_of

ROOT = Path(__file__).resolve().parents[1]

# Packages whose code determines a verdict
VERDICT = ("monitors", "methods", "models", "vehicles", "io", "physics", "core")


def fingerprint(*values: Any) -> str:
    """SHA-256 of values, in hexadecimal: equal for equal content in every process, whatever its hash seed.

    Args:
        values: dataclasses, mappings, sequences, arrays, sets, texts, numbers; a path contributes its name only,
            since its content is fingerprinted separately, as does a function; fields excluded from comparisons are
            ignored
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
def verdict_code() -> str:
    """Digest of the code that determines a verdict."""
    return fingerprint([contents(ROOT / package) for package in VERDICT])


@cache
def installed_code() -> str:
    """Digest of all code of tierod, and of the packages that add to it by `tierod.core.plugins`."""
    return fingerprint([contents(root) for root in (ROOT, *lab.folders())])


def contents(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.suffix in (".py", ".c", ".csv"))
    return {path.relative_to(folder).as_posix(): sha256_of(path) for path in files}
