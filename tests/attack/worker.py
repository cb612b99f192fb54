"""A process that runs commands of tierod one after the other, each within limits, and says what became of each.

Lines of JSON come in: {"arguments": [...], "folder": "...", "encoding": "..."}; one goes out for each. What a command
prints goes into the files `stdout` and `stderr` above the folder. The process ends by SIGPROF where a command takes
more processor time than it may.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import resource
import signal
import sys
import time
import traceback
from typing import Any

SECONDS = 10.0
"""Of processor time that a command may take [s]; waiting is limited by the parent."""

MEMORY = 1_500_000_000
"""That a command may take [bytes], beyond what the libraries take up."""

FILE_SIZE = 300_000_000
"""That a file which a command writes may have [bytes]."""

_DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of Linux."""


def main(folder: str) -> None:
    """Serve until the input ends."""
    # A worker that waits for ever in a command would outlive an attack that is stopped.
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    ask, answer = os.fdopen(os.dup(0), "r"), os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    streams = [os.open(f"{folder}/{name}", os.O_RDWR | os.O_CREAT, 0o600) for name in ("stdout", "stderr")]
    for number, stream in enumerate(streams, 1):
        os.dup2(stream, number)
    _warm_up()
    _limit()
    answer.write("ready\n")
    answer.flush()
    for line in ask:
        wish = json.loads(line)
        for number in (1, 2):
            os.ftruncate(number, 0)
            os.lseek(number, 0, os.SEEK_SET)
        sys.stdout.reconfigure(encoding=wish.get("encoding", "utf-8"), errors="strict")
        sys.stderr.reconfigure(encoding=wish.get("encoding", "utf-8"), errors="backslashreplace")
        os.chdir(wish["folder"])
        result = _run(wish["arguments"])
        os.chdir("/")
        answer.write(json.dumps(result) + "\n")
        answer.flush()
        gc.collect()


def _warm_up() -> None:
    """Libraries that commands import anyway, so that the first case pays no more than the others."""
    import asammdf
    import can
    import cantools
    import casadi
    import pint
    import plotly
    import pyarrow.csv
    import pyarrow.parquet
    import rich.console
    import scipy.io
    import typer

    from tierod.cli import main as _main

    assert all((asammdf, can, cantools, casadi, pint, plotly, pyarrow, rich, scipy, typer, _main))
    gc.collect()
    gc.freeze()


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_SIZE, FILE_SIZE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # Beyond the size of a file comes an OSError rather than a signal.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def _status(name: str) -> int:
    """A figure of /proc/self/status [bytes]."""
    with open("/proc/self/status", encoding="ascii") as file:
        line = next(line for line in file if line.startswith(f"{name}:"))
    return int(line.split()[1]) * 1024


def _run(arguments: list[str]) -> dict[str, Any]:
    from tierod.cli import main as command

    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")  # the highest resident memory counts anew
    before, children, began, cpu = _status("VmRSS"), _children(), time.monotonic(), time.process_time()
    # Libraries reserve more than they use, and keep it: what counts is what this command asks for.
    resource.setrlimit(resource.RLIMIT_AS, (_status("VmSize") + MEMORY, resource.RLIM_INFINITY))
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    sys.argv = ["tierod", *arguments]
    code, escaped = _coded(command, arguments)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    result = {
        "code": code,
        "escaped": escaped,
        "seconds": time.process_time() - cpu + _children()[0] - children[0],
        "waited": time.monotonic() - began,
        "memory": max(_status("VmHWM") - before, _children()[1] if _children()[1] > children[1] else 0, 0),
        "resident": before,
    }
    if code == 4:
        result["where"] = _coded(command, [*arguments, "--debug"])[1]
    return result


def _children() -> tuple[float, int]:
    """Processor time of the processes that commands started [s], and the largest of those that ended so far [bytes]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def _coded(command: Any, arguments: list[str]) -> tuple[int | None, str]:
    """The exit code, or the traceback of what escaped."""
    try:
        code = command(arguments)
        sys.stdout.flush()
        sys.stderr.flush()
    except BaseException as error:
        text = "".join(traceback.format_exception(error))
        return None, text if len(text) < 20_000 else f"{text[:12_000]}\n...\n{text[-6000:]}"
    return code, ""


if __name__ == "__main__":
    main(sys.argv[1])
