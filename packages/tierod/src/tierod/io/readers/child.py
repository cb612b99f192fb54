"""The process that reads a file with a library whose native code can crash on a damaged file.

It is a separate script that imports nothing of tierod, so that it starts fast. It imports the library, and forks for
every file. The fork takes requests, one JSON document per line, and answers each with such a line, followed by the
arrays that the line lists. `tierod.io.readers.reader_process` is the other
end. Arrays are sent as bare numbers, so that the output of a damaged process can do no harm there. The class `Reader`
of the script that is named on the command line makes the answers.
"""

from __future__ import annotations

import contextlib
import json
import os
import runpy
import socket
import sys
import tempfile
import warnings
from typing import TYPE_CHECKING, Any, BinaryIO

if TYPE_CHECKING:
    import numpy as np

REQUEST = 1 << 16  # Size of the buffer for a request for a reader [bytes]: a path and some numbers


def main() -> None:
    """Import the library, and start readers until the other end closes the socket."""
    line = socket.socket(fileno=os.dup(0))
    kind = runpy.run_path(sys.argv[1])["Reader"]
    kind.prepare()
    while message := socket.recv_fds(line, REQUEST, 1):
        text, ends, _, _ = message
        if not text:
            return
        request = json.loads(text)
        if "ended" in request:
            line.send(json.dumps({"code": _code(request["ended"])}).encode())
            continue
        pid = os.fork()
        if not pid:
            line.close()
            if request["folder"]:
                tempfile.tempdir = request["folder"]
                os.environ.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), request["folder"]))
            read(kind, request["path"], request["memory"], ends[0])
            return
        for end in ends:
            os.close(end)
        line.send(json.dumps({"pid": pid}).encode())


def _code(pid: int) -> int | None:
    try:
        found, status = os.waitpid(pid, os.WNOHANG)
    except ChildProcessError:
        return 0  # its exit code was collected by an earlier request
    return os.waitstatus_to_exitcode(status) if found else None


def read(kind: type, path: str, memory: int, line: int) -> None:
    """Answer requests on one file over a socket until the other end closes it.

    Args:
        memory: memory that it may take beyond the present use [bytes]; 0 sets no limit
    """
    os.dup2(line, 0)
    # What the library prints goes to the error output, not between the answers.
    os.dup2(2, 1)
    limit_memory(memory)
    begun = computed()
    warnings.simplefilter("ignore")
    with os.fdopen(line, "wb") as answers:
        reader = kind(path)
        for line_of_text in sys.stdin:
            request = json.loads(line_of_text)
            columns: dict[str, Any] = {}
            try:
                limit_time(begun + request["seconds"])
                columns, answer = reader.answer(request)
            except MemoryError:
                answer = {"memory": memory}
            except Exception as error:
                answer = {"error": " ".join(str(error).split())[:160] or type(error).__name__}
            _send(answers, columns, answer)


def limit_memory(more: int) -> None:
    """Limit the memory to the present use and some more [bytes]; 0 sets no limit."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        with open("/proc/self/statm") as file:
            now = int(file.read().split()[0]) * resource.getpagesize()
        if more:
            resource.setrlimit(resource.RLIMIT_AS, (now + more, now + more))


def computed() -> float:
    with contextlib.suppress(ImportError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        return used.ru_utime + used.ru_stime
    return 0.0


def limit_time(seconds: float) -> None:
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, hard))


def _send(answers: BinaryIO, columns: dict[str, np.ndarray], about: dict[str, object]) -> None:
    listed = {name: (values.dtype.str, values.shape) for name, values in columns.items()}
    answers.write(json.dumps(about | {"arrays": listed}).encode() + b"\n")
    for values in columns.values():
        answers.write(values.data.cast("B") if values.size else b"")
    answers.flush()


if __name__ == "__main__":
    main()
