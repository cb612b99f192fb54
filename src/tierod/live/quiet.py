"""Interpreter settings for a process that must act every ten milliseconds for hours, without long pauses of Python."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

from tierod.core.series import Rows

SWITCH: Annotated[float, "s"] = 5e-4
"""Time that a thread may keep the interpreter while another one waits; Python's default of 5 ms is half a tick."""

YOUNG = 50_000
"""Number of new objects that starts a collection of the youngest generation; frames come by the thousand, and form no
reference cycles.
"""


@contextmanager
def quiet() -> Iterator[None]:
    """Exclude imported objects from garbage collection, switch threads sooner, and allocate bounded series at once.

    A full collection scans all modules: 50 to 100 ms, at any moment.
    """
    before = gc.get_threshold(), sys.getswitchinterval(), Rows.reserving
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, 20, 100)
    sys.setswitchinterval(SWITCH)
    Rows.reserving = True
    try:
        yield
    finally:
        gc.unfreeze()
        gc.set_threshold(*before[0])
        sys.setswitchinterval(before[1])
        Rows.reserving = before[2]
