"""A process that shall come back every ten milliseconds for hours: what else Python does in between is moved away."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

from tierod.core.series import Rows

SWITCH: Annotated[float, "s"] = 5e-4
"""Time for which a thread may keep the interpreter while another one waits; Python's 5 ms are half a tick."""

YOUNG = 50_000
"""New objects from which on the youngest are looked through: frames come by the thousand, and hold no circles."""


@contextmanager
def quiet() -> Iterator[None]:
    """Garbage collection leaves alone what was imported, threads give way sooner, and bounded series take their memory.

    A full collection looks through all modules: 50 to 100 ms, at any moment.
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
