"""Standard streams that the caller has closed, and an output whose reader is gone."""

from __future__ import annotations

import contextlib
import io
import os
import sys


def open_closed_streams() -> None:
    """Put a stream in the place of each standard stream that is closed; otherwise the next file takes its number.

    An output that is closed becomes a pipe without a reader: it fails at the first write, as if its reader had gone.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            place = _without_reader() if number == 1 else os.open(os.devnull, os.O_RDWR)
            if place != number:
                os.dup2(place, number)
                os.close(place)
    if sys.stdin is None:
        sys.stdin = open(0, closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), write_through=True)


def _without_reader() -> int:
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def failed_output(error: OSError) -> int:
    """Exit code of a text that could not be printed: 141 where its reader is gone, else 3 with a sentence."""
    if isinstance(error, BrokenPipeError):
        return 141
    complain(f"{(error.strerror or str(error)).lower()}; make room, or send the output to another place")
    return 3


def abandon_output() -> None:
    """Redirect stdout, whose reader is gone, so that the flush at exit raises no further error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complain(sentence: str) -> None:
    """Print an error to stderr; where that fails too, only the exit code can say it."""
    with contextlib.suppress(OSError):
        print(f"tierod: {sentence}", file=sys.stderr, flush=True)
