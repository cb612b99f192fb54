"""Shared library of a unit, built for the present platform."""

from __future__ import annotations

import platform
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from tierod.core.errors import CompileError
from tierod.core.graph.compiler import compiler
from tierod.export.evidence.tools import ran

FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-fno-math-errno", "-ffp-contract=off")
"""Compiler flags for any processor of the platform, not only the present one."""

_PLACES = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib"), "win32": ("win64", ".dll")}


def place_of_binary() -> tuple[str, str]:
    """Folder and file suffix of a binary for this platform.

    Raises:
        CompileError: the standard defines no name for this platform
    """
    intel = platform.machine().lower() in ("amd64", "x86_64")
    place = _PLACES.get(sys.platform)
    if place is None or not (intel or sys.platform == "darwin"):
        raise CompileError(
            f"FMI 2.0 has no name for the platform '{platform.machine()}, {sys.platform}'; export on a computer with "
            "an x86-64 processor"
        )
    return place


def built(texts: Mapping[str, str], names: Sequence[str]) -> bytes:
    """Shared library compiled from sources.

    Raises:
        CompileError: no compiler is installed, or it rejects the sources
    """
    command = compiler()
    if command is None:
        raise CompileError(
            "a functional mock-up unit holds a binary, and no C compiler was found (looked for cc, gcc, clang and the "
            "wheel ziglang); install one, or pip install 'tierod[compiler]'"
        )
    with tempfile.TemporaryDirectory(prefix="tierod-") as name:
        folder = Path(name)
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="utf-8")
        done = ran([*command, *FLAGS, *names, "-o", "unit.bin", "-lm"], folder)
        if done.code != 0 or not (folder / "unit.bin").is_file():
            raise CompileError(f"the C compiler '{' '.join(command)}' refused a generated unit ({done.first})")
        return (folder / "unit.bin").read_bytes()
