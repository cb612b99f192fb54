"""Compile printed C into a shared library, cached by content in the user's cache folder."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import stat
import subprocess
import sys
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from tierod.errors import CompileError

_LIBRARY_FUNCTIONS = "sin cos tan asin acos atan atan2 sinh cosh tanh exp expm1 log log1p pow hypot"

FLAGS = (
    *("-std=c99", "-O3", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"),
    *(f"-fno-builtin-{name}" for name in _LIBRARY_FUNCTIONS.split()),
)
"""Never -ffast-math: it breaks NaN and, once loaded, flushes denormals in the whole process. Nor may the compiler work
out a library function itself: GCC rounds constants differently, and makes 0 of cos(atan(NaN))."""

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
        CompileError: there is no compiler, it refuses the source, or its product cannot be loaded
    """
    command = compiler()
    if command is None:
        raise CompileError(
            "no C compiler was found (looked for cc, gcc, clang and the wheel ziglang); install one, "
            "or pip install 'tierod[compiler]', or run with engine='virtual machine'"
        )
    library = library_path(command, source, name)
    if library.exists():
        try:
            return ctypes.PyDLL(str(library))
        except OSError:
            library.unlink(missing_ok=True)  # damaged, by a full disk or a copy: compiled anew
    _compile(command, source, library)
    try:
        return ctypes.PyDLL(str(library))
    except OSError as error:
        raise CompileError(
            f"a compiled kernel cannot be loaded ({error}); name a folder that may hold programs with the environment "
            "variable TIEROD_CACHE, or run with engine='virtual machine'"
        ) from None


def library_path(command: tuple[str, ...], source: str, name: str) -> Path:
    """Where the library of a source lies: the name holds all that its code depends on."""
    parts = [*command, _identity(command[0]), _machine(), *FLAGS, *NATIVE, *SCHEDULED, source]
    key = hashlib.sha256("\0".join(parts).encode())
    return _writable(cache_folder()) / f"{name}-{key.hexdigest()[:24]}.so"


def _compile(command: tuple[str, ...], source: str, library: Path) -> None:
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as folder:
        code, built = Path(folder, "kernel.c"), Path(folder, "kernel.so")
        code.write_text(source)
        for native in (NATIVE + SCHEDULED, NATIVE, NATIVE[:1], ()):
            try:
                run = subprocess.run(
                    [*command, *FLAGS, *native, str(code), "-o", str(built), "-lm"],
                    capture_output=True,
                    text=True,
                    check=False,
                )
            except OSError as error:
                raise CompileError(
                    f"the C compiler '{command[0]}' cannot be run ({error.strerror}); "
                    "name another one with the environment variable TIEROD_CC (empty for none)"
                ) from None
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
    return _fallback_folder()


@cache
def _fallback_folder() -> Path:
    """A folder among the temporary ones that nobody else can put a kernel into."""
    if hasattr(os, "getuid"):
        fallback = Path(tempfile.gettempdir()) / f"tierod-{os.getuid()}"
        fallback.mkdir(mode=0o700, exist_ok=True)
        found = fallback.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
            return fallback
    return Path(tempfile.mkdtemp(prefix="tierod-"))
