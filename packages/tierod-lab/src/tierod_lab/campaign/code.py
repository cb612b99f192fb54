"""Digests of the code that determines simulated drives, their judgement, and the results of a study."""

from __future__ import annotations

import ast
import platform
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from tierod.core.block import Block
from tierod.core.files import sha256_of
from tierod.core.graph.analysis import graph_digest
from tierod.core.version import __version__
from tierod.work.fingerprint import ROOT as PRODUCT
from tierod.work.fingerprint import contents, fingerprint, verdict_code

ROOT = Path(__file__).resolve().parents[1]

JUDGE = ("figures", "judging")  # Modules of this package that compare a verdict with the true values

STUDIES = ("tierod_lab.papers.", "tierod_lab.campaign.", "tierod_lab.studies.", "tierod_lab.fleet.", "tierod.fleet.")
"""Prefixes of the packages whose code belongs to studies."""


@cache
def ground_code() -> str:
    """Digest of what determines a drive besides its scenario: tierod's code, NumPy's version, the processor type."""
    code = [contents(ROOT / "ground"), contents(PRODUCT / "physics"), contents(PRODUCT / "core")]
    return fingerprint(code, __version__, np.__version__, platform.machine())


@cache
def judging_code() -> str:
    """Digest of the code that determines a verdict and its comparison with the truth."""
    return fingerprint(verdict_code(), [sha256_of(Path(__file__).with_name(f"{name}.py")) for name in JUDGE])


@cache
def work_code(module: str) -> str:
    """Digest of the code that determines the results of a module: drives, methods, the module and its imports.

    Of the packages of studies only the files that the module imports directly or indirectly are included, so that a
    change of a claim or a chart leaves the drives of a study valid.
    """
    files: set[Path] = set()
    waiting = [module]
    while waiting:
        path = _file_of(waiting.pop())
        if path is not None and path not in files:
            files.add(path)
            waiting += [name for name in _imports(path) if name.startswith(STUDIES) and " " not in name]
    return fingerprint(ground_code(), judging_code(), sorted(map(sha256_of, files)))


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


def reported_seed(*blocks: Block) -> int:
    """Seed of reported drives, from the graphs and the tuning of the judged monitor.

    A change of a threshold or an equation changes the drives; moving a file does not.
    """
    return int(graph_digest(*blocks)[:6], 16)
