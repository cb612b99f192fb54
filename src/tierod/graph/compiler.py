"""Compile printed C into a shared library, cached by content in the user's cache folder."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from tierod.errors import CompileError

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")
"""Never -ffast-math: it breaks NaN and, once loaded, flushes denormals in the whole process."""

NATIVE = ("-march=native", "-mprefer-vector-width=512")

SCHEDULED = ("-fschedule-insns", "-fsched-pressure", "-fira-loop-pressure")
"""GCC's order of instructions for long straight lines in vector registers: about 6 % of a lane's time."""


@cache
def compiler() -> tuple[str, ...] | None:
    """The command of the C compiler: TIEROD_CC, the system's own, the one in the wheel `ziglang`, or None."""
    chosen = os.environ.get("TIEROD_CC")
    if chosen is not None:
        return tuple(chosen.split()) if chosen else None
    for name in ("cc", "gcc", "clang"):
        if path := shutil.which(name):
            return (path,)
    if find_spec("ziglang"):
        return (sys.executable, "-m", "ziglang", "cc")
    return None


def cache_folder() -> Path:
    """Where compiled kernels are kept: TIEROD_CACHE, or `tierod` in the user's cache folder."""
    if chosen := os.environ.get("TIEROD_CACHE"):
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tierod"


def load(source: str, name: str) -> ctypes.PyDLL:
    """The library compiled from C source; compiled only where the cache does not hold it.

    PyDLL keeps the interpreter's lock: one push is shorter than giving the lock away and taking it back.

    Raises:
        CompileError: there is no compiler, or it refuses the source
    """
    command = compiler()
    if command is None:
        raise CompileError(
            "no C compiler was found (looked for cc, gcc, clang and the wheel ziglang); install one, "
            "or pip install 'tierod[compiler]', or run with engine='virtual machine'"
        )
    key = hashlib.sha256(
        "\0".join([*command, _identity(command[0]), _machine(), *FLAGS, *NATIVE, *SCHEDULED, source]).encode()
    )
    folder = _writable(cache_folder())
    library = folder / f"{name}-{key.hexdigest()[:24]}.so"
    if not library.exists():
        _compile(command, source, library)
    return ctypes.PyDLL(str(library))


def _compile(command: tuple[str, ...], source: str, library: Path) -> None:
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as folder:
        code, built = Path(folder, "kernel.c"), Path(folder, "kernel.so")
        code.write_text(source)
        for native in (NATIVE + SCHEDULED, NATIVE, NATIVE[:1], ()):
            run = subprocess.run(
                [*command, *FLAGS, *native, str(code), "-o", str(built), "-lm"],
                capture_output=True,
                text=True,
                check=False,
            )
            if run.returncode == 0:
                os.replace(built, library)
                return
    raise CompileError(
        f"the C compiler '{' '.join(command)}' refused generated code ({_first_error(run.stderr)}); "
        "choose another one with the environment variable TIEROD_CC (empty for none)"
    )


def _first_error(text: str) -> str:
    lines = text.strip().splitlines()
    return next((line for line in lines if "error" in line), lines[0] if lines else "it said nothing")


def _identity(executable: str) -> str:
    path = Path(shutil.which(executable) or executable).resolve()
    try:
        status = path.stat()
    except OSError:
        return str(path)
    return f"{path} {status.st_size} {status.st_mtime_ns}"


@cache
def _machine() -> str:
    """What -march=native depends on, so that a cache on a shared home folder never gives a foreign kernel."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in text.splitlines() if line.startswith(("flags", "Features"))), platform.machine())


def _writable(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    fallback = Path(tempfile.gettempdir()) / f"tierod-{os.getuid() if hasattr(os, 'getuid') else 'kernels'}"
    fallback.mkdir(mode=0o700, exist_ok=True)
    return fallback
