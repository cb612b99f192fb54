"""Compile printed C into a shared library, kept by content in the user's cache folder, and load it from memory."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import itertools
import os
import platform
import shutil
import subprocess
import tempfile
import warnings
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from tierod.core.errors import CompileError, KernelWarning, OutputError
from tierod.core.graph.kernel_cache import KernelCache, NoCache
from tierod.core.processes import interpreter

_SERIAL = itertools.count(1)


def loaded(code: bytes, name: str) -> ctypes.PyDLL:
    if hasattr(os, "memfd_create"):
        # It fails without /proc, or where files in memory must not be executed; then the file below is used.
        with contextlib.suppress(OSError):
            return _from_memory(code, name)
    with tempfile.TemporaryDirectory(prefix="tierod-") as folder:
        path = Path(folder, f"{name}.so")
        path.write_bytes(code)
        return ctypes.PyDLL(str(path))


def _from_memory(code: bytes, name: str) -> ctypes.PyDLL:
    handle = os.memfd_create(name[:200])
    try:
        with open(handle, "wb", closefd=False) as file:
            file.write(code)
        # The loader takes equal paths for the same library, and descriptors are reused: the serial number makes every
        # path unique. It is written in binary with "./" for 0 and "/" for 1, which do not change where the path leads.
        serial = f"{next(_SERIAL):b}".replace("1", "/").replace("0", "./")
        return ctypes.PyDLL(f"/proc/self/fd/{serial}{handle}")
    finally:
        os.close(handle)


# Never -ffast-math: it breaks NaN and, once loaded, flushes denormals in the whole process
FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off")

NATIVE = ("-march=native", "-mprefer-vector-width=512")

# GCC's instruction order for long straight lines in vector registers, which saves about 6 % of a lane's time; and
# selections among many values without a branch, else a loop over lanes with many decisions does not vectorise
TUNED = (
    *("-fschedule-insns", "-fsched-pressure", "-fira-loop-pressure"),
    "--param=max-tree-if-conversion-phi-args=1000",
)

# Optimisations that are turned off: a graph has no repeated expression and no loop to split, and to search for them
# takes a third of a compilation. Loops over lanes, which GCC would split, run up to a fifth faster without them. Large
# functions get the allocator of registers without a table of conflicts: it takes a sixth to a third less time to
# compile them, and their code is as fast.
LEAN = (
    *("-fno-tree-pre", "-fno-code-hoisting", "-fno-gcse", "-fno-gcse-after-reload"),
    *("-fno-tree-loop-distribution", "-fno-tree-loop-distribute-patterns", "-fno-loop-unroll-and-jam"),
    "--param=ira-max-conflict-table-size=2",
)

X86 = platform.machine() in ("x86_64", "AMD64")

_FEW = "-mtune-ctrl=use_gather_4parts"

# Names in GCC 12 and in GCC 13 for vector look-ups in a table (gather), of four numbers and of more. On AMD processors
# and on x86 processors that it does not recognise, GCC does not use them by itself. Lanes with a sine, which looks up
# digits of pi for large angles, are then not vectorised and take two to four times as long.
GATHERED = (f"{_FEW},use_gather", f"{_FEW},use_gather_8parts") if X86 else ()

# Longest time of one compilation [s]: ten times what the largest kernel takes on a slow machine
LONGEST: Annotated[float, "s"] = 600.0


@cache
def compiler() -> tuple[str, ...] | None:
    """The command of the C compiler: TIEROD_CC, that of the system, that in the wheel `ziglang`, or None."""
    chosen = os.environ.get("TIEROD_CC")
    if chosen is not None:
        return tuple(chosen.split()) if chosen else None
    for name in ("cc", "gcc", "clang"):
        if path := shutil.which(name):
            return (path,)
    if find_spec("ziglang"):
        return interpreter("-m", "ziglang", "cc")
    return None


def _more() -> tuple[str, ...]:
    """Options of TIEROD_CFLAGS, which override ours: -O1 compiles in a third of the time and runs a third slower."""
    return tuple(os.environ.get("TIEROD_CFLAGS", "").split())


def cache_folder() -> Path:
    """Folder of compiled kernels: TIEROD_CACHE, or `tierod` in the user's cache folder."""
    if chosen := os.environ.get("TIEROD_CACHE"):
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "tierod"


def load(source: str, name: str) -> ctypes.PyDLL:
    """The library of C source; it is compiled only where no cache holds it.

    PyDLL keeps the interpreter lock: a push takes less time than to release and acquire the lock.
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
    """The library of a kernel from a cache; None where no cache holds it."""
    caches = _caches()
    for place in caches:
        code = place.kept(kernel)
        if code is not None:
            try:
                library = loaded(code, kernel)
            except OSError:  # built for another C library, for example: it is compiled again
                place.forget(kernel)
            else:
                _warn_once([caches[0].trouble()], place.where)
                return library
    return None


def kept(name: str) -> bytes | None:
    """The verified content that a cache holds under a name; None where no cache holds it."""
    return next((found for place in _caches() if (found := place.kept(name)) is not None), None)


def keep(name: str, content: bytes) -> None:
    """Keep a content in the first cache that accepts it; where none does, the next process makes it again."""
    for place in _caches():
        with contextlib.suppress(OutputError), place.building(name):
            place.keep(name, content)
            return


def kernel_name(command: tuple[str, ...], source: str, name: str) -> str:
    """The name of a kernel in the cache, with a digest of all that its code depends on."""
    parts = [*command, identity(command[0]), _machine(), *FLAGS, *NATIVE, *TUNED, *LEAN, *GATHERED, *_more(), source]
    key = hashlib.sha256("\0".join(parts).encode())
    return f"{name}-{key.hexdigest()[:24]}"


def _caches() -> tuple[KernelCache | NoCache, ...]:
    found = []
    with contextlib.suppress(RuntimeError):  # a user without a home
        found.append(KernelCache(cache_folder()))
    with contextlib.suppress(OSError, AttributeError):  # no temporary folder, or a system without user identifiers
        found.append(KernelCache(Path(tempfile.gettempdir()) / f"tierod-{os.getuid()}"))
    return *found, NoCache()


def _built(
    command: tuple[str, ...], source: str, kernel: str, caches: tuple[KernelCache | NoCache, ...]
) -> ctypes.PyDLL:
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
            code, refusal = None, error  # perhaps the disk there is full: one more try in the next place
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
    """Warn once per process that kernels are not in their usual folder, with the reason and the folder."""
    trouble = next(filter(None, troubles), "")
    if trouble and not _WARNED:
        _WARNED.add(trouble)
        warnings.warn(f"{trouble}. Compiled kernels are kept {where}", KernelWarning, stacklevel=2)


def _compiled(command: tuple[str, ...], source: str, folder: Path) -> bytes:
    code, built = folder / "kernel.c", folder / "kernel.so"
    code.write_text(source, encoding="utf-8")
    # From the fastest code to the plainest: a compiler refuses options that it does not know.
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
            # Temporary files of the compiler are removed with the folder, even where it is killed.
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
    """Path, size and modification time of a program or module."""
    path = Path(shutil.which(executable) or executable).resolve()
    try:
        status = path.stat()
    except OSError:
        return str(path)
    return f"{path} {status.st_size} {status.st_mtime_ns}"


@cache
def _machine() -> str:
    """Processor features that -march=native depends on, so that a shared cache never gives a foreign kernel."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in text.splitlines() if line.startswith(("flags", "Features"))), platform.machine())


def vector_width() -> int:
    """Number of doubles in the widest vector register of this machine, where the system states it; else four."""
    return 8 if "avx512f" in _machine().split() else 4
