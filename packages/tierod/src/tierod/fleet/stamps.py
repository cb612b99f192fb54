"""Digests of everything that determines a result beside the recording: code, and vehicle with its files."""

from __future__ import annotations

import inspect
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np

from tierod.core.files import sha256_of
from tierod.core.version import __version__
from tierod.monitors.registry import MONITORS
from tierod.monitors.session import Monitor
from tierod.vehicles import Vehicle
from tierod.work.fingerprint import fingerprint, verdict_code

OWN = Path(__file__).parent

DECIDING = ("judging.py", "levels.py", "schema.py")  # Files of this package that determine the content of a result


@cache
def code() -> str:
    """Digest of all code that determines a result: that of tierod, and that of monitors from other packages."""
    own = [_content(OWN / name) for name in DECIDING]
    others = [_content(path) for name in MONITORS.plugin_names() for path in _sources(MONITORS[name])]
    return fingerprint(verdict_code(), own, others, __version__, np.__version__)


@cache
def report_code() -> str:
    return fingerprint(code(), [_content(path) for path in sorted(OWN.glob("*.py"))])


def vehicle_digest(car: Vehicle) -> str:
    """Digest of a vehicle: its content, and the files that describe its bus."""
    files = [_content(path) for path in (car.channel_map, car.database) if path is not None]
    return fingerprint(car, files)


def _sources(monitor: Monitor) -> list[Path]:
    found = set()
    for variant in monitor.variants.values():
        with suppress(TypeError):
            found.add(Path(inspect.getfile(inspect.unwrap(variant.open))))
    return sorted(found)


def _content(path: Path) -> str:
    try:
        return sha256_of(path)
    except OSError:
        return "absent"
