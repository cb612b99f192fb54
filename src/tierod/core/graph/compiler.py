"""Compile printed C into a shared library, kept by content in the user's cache folder."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import warnings
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from tierod.core.errors import CompileError, KernelWarning, OutputError
from tierod.core.graph.kernel_cache import KernelCache, NoCache
from tierod.core.graph.shared_library import loaded

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")
"""Never -ffast-math: it breaks NaN and, once loaded, flushes denormals in the whole process."""

NATIVE = ("-march=native", "-mprefer-vector-width=512")

TUNED = (
    *("-fschedule-insns", "-fsched-pressure", "-fira-loop-pressure"),
    "--param=max-tree-if-conversion-phi-args=1000",
)
"""GCC's order of instructions for long straight lines in vector registers, about 6 % of a lane's time. And selections
of any number of values without a branch: without it a loop over lanes that decides much does not vectorise."""

LEAN = (
    *("-fno-tree-pre", "-fno-code-hoisting", "-fno-gcse", "-fno-gcse-after-reload"),
    *("-fno-tree-loop-distribution", "-fno-tree-loop-distribute-patterns", "-fno-loop-unroll-and-jam"),
)
"""A graph has no expression twice and no loop to split: the searches of GCC for them take a third of a compilation and
find nothing. Loops over lanes, which they cut into several, run up to a fifth faster without."""

X86 = platform.machine() in ("x86_64", "AMD64")

_FEW = "-mtune-ctrl=use_gather_4parts"

GATHERED = (f"{_FEW},use_gather", f"{_FEW},use_gather_8parts") if X86 else ()
"""GCC 12's and GCC 13's name for vector look-ups of a table, of four numbers and of more. For a processor of x86 that
it does not know by name, and for AMD's, it does without them, and lanes with a sine, which looks up digits of pi for
large angles, then are not vectorised and take two to four times as long."""

LONGEST: Annotated[float, "s"] = 600.0
"""Time of one compilation, ten times what the largest kernel takes on a slow machine."""


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


def _more() -> tuple[str, ...]:
    """Options of TIEROD_CFLAGS, which win over ours: -O1 compiles in a third of the time and runs a third slower."""
    return tuple(os.environ.get("TIEROD_CFLAGS", "").split())


def cache_folder() -> Path:
    """Folder of compiled kernels: TIEROD_CACHE, or `tierod` in the user's cache folder."""
    if chosen := os.environ.get("TIEROD_CACHE"):
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "tierod"


def load(source: str, name: str) -> ctypes.PyDLL:
    """The library compiled from C source; compiled only where no cache holds it.

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
    kernel = kernel_name(command, source, name)
    return load_kept(kernel) or _built(command, source, kernel, _caches())


def load_kept(kernel: str) -> ctypes.PyDLL | None:
    """The library of a kernel that a cache holds; None where none does.

    Args:
        kernel: its name
    """
    caches = _caches()
    for place in caches:
        code = place.kept(kernel)
        if code is not None:
            try:
                library = loaded(code, kernel)
            except OSError:  # of another C library, for example: compiled anew
                place.forget(kernel)
            else:
                _warn_once([caches[0].trouble()], place.where)
                return library
    return None


def kept(name: str) -> bytes | None:
    """What the caches hold under a name, verified; None where they hold nothing."""
    return next((found for place in _caches() if (found := place.kept(name)) is not None), None)


def keep(name: str, content: bytes) -> None:
    """Keep something in the first cache that takes it; without room it is made anew by the next process."""
    for place in _caches():
        with contextlib.suppress(OutputError), place.building(name):
            place.keep(name, content)
            return


def kernel_name(command: tuple[str, ...], source: str, name: str) -> str:
    """The name of a kernel in the cache, with a digest of all that its code depends on.

    Args:
        command: of the compiler
        source: printed C
        name: of the block, the first part of the name
    """
    parts = [*command, identity(command[0]), _machine(), *FLAGS, *NATIVE, *TUNED, *LEAN, *GATHERED, *_more(), source]
    key = hashlib.sha256("\0".join(parts).encode())
    return f"{name}-{key.hexdigest()[:24]}"


def _caches() -> tuple[KernelCache | NoCache, ...]:
    """Caches that kernels are looked for and kept in, the user's own choice first."""
    found = []
    with contextlib.suppress(RuntimeError):  # a user without a home
        found.append(KernelCache(cache_folder()))
    with contextlib.suppress(OSError, AttributeError):  # no temporary folder, or a system without numbers of users
        found.append(KernelCache(Path(tempfile.gettempdir()) / f"tierod-{os.getuid()}"))
    return *found, NoCache()


def _built(
    command: tuple[str, ...], source: str, kernel: str, caches: tuple[KernelCache | NoCache, ...]
) -> ctypes.PyDLL:
    """Compile and load a kernel, and keep it in the first cache that takes it."""
    library: ctypes.PyDLL | None = None
    code: bytes | None = None
    troubles: list[str] = []
    refusal: CompileError | None = None
    for place in caches:
        try:
            with place.building(kernel) as folder:
                # Another process may have compiled it while this one waited for the folder.
                code = code or place.kept(kernel) or _compiled(command, source, folder)
                library = library or _of_compiler(code, kernel)
                place.keep(kernel, code)
        except OutputError as error:
            troubles.append(str(error))
        except CompileError as error:
            if refusal is not None:
                raise
            code, refusal = None, error  # perhaps for lack of room there: tried once more in the next place
        else:
            _warn_once(troubles, place.where)
            return library
    if library is None:
        raise refusal or CompileError(f"no folder was found to compile in: {'; '.join(troubles)}")
    return library


def _of_compiler(code: bytes, kernel: str) -> ctypes.PyDLL:
    try:
        return loaded(code, kernel)
    except OSError as error:
        raise CompileError(
            f"a compiled kernel cannot be loaded ({error}); name another compiler with the environment variable "
            "TIEROD_CC or another temporary folder with TMPDIR, or run with engine='virtual machine'"
        ) from None


_WARNED: set[str] = set()


def _warn_once(troubles: list[str], where: str) -> None:
    """Warn once in a process why kernels are not in their usual place, and where they are."""
    trouble = next(filter(None, troubles), "")
    if trouble and not _WARNED:
        _WARNED.add(trouble)
        warnings.warn(f"{trouble}. Compiled kernels are kept {where}", KernelWarning, stacklevel=2)


def _compiled(command: tuple[str, ...], source: str, folder: Path) -> bytes:
    """The code that the compiler makes of a source.

    Raises:
        CompileError: it refuses, or makes nothing
        OSError: the folder cannot be written
    """
    code, built = folder / "kernel.c", folder / "kernel.so"
    code.write_text(source, encoding="utf-8")
    best = [(*NATIVE, *TUNED, *LEAN, each) for each in GATHERED]
    for native in (*best, NATIVE + TUNED + LEAN, NATIVE + TUNED, NATIVE, NATIVE[:1], ()):
        run = _run([*command, *FLAGS, *native, *_more(), str(code), "-o", str(built), "-lm"], folder)
        if run.returncode == 0:
            if not built.is_file() or not built.stat().st_size:
                raise CompileError(
                    f"the C compiler '{' '.join(command)}' ended well but wrote nothing; "
                    "choose another one with the environment variable TIEROD_CC (empty for none)"
                )
            return built.read_bytes()
    raise CompileError(
        f"the C compiler '{' '.join(command)}' refused generated code ({_first_error(run.stderr)}); "
        "choose another one with the environment variable TIEROD_CC (empty for none)"
    )


def _run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=LONGEST,
            # Its own temporary files go with the folder, also where it is killed.
            env={**os.environ, "TMPDIR": str(folder)},
        )
    except subprocess.TimeoutExpired:
        said = f"did not end within {LONGEST:g} s"
    except OSError as error:
        said = f"cannot be run ({error.strerror})"
    raise CompileError(
        f"the C compiler '{command[0]}' {said}; "
        "name another one with the environment variable TIEROD_CC (empty for none)"
    )


def _first_error(text: str) -> str:
    lines = text.strip().splitlines()
    return next((line for line in lines if "error" in line), lines[0] if lines else "it said nothing")


def identity(executable: str) -> str:
    """Place, size and time of change of a program or module."""
    path = Path(shutil.which(executable) or executable).resolve()
    try:
        status = path.stat()
    except OSError:
        return str(path)
    return f"{path} {status.st_size} {status.st_mtime_ns}"


@cache
def _machine() -> str:
    """Machine that -march=native depends on, so that a cache on a shared home folder never gives a foreign kernel."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in text.splitlines() if line.startswith(("flags", "Features"))), platform.machine())


def vector_width() -> int:
    """Numbers that the widest vector register of this machine holds, as far as its system names it; else four."""
    return 8 if "avx512f" in _machine().split() else 4
