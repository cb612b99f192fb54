"""How one signal is made from others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tierod.core.recording import Channel


@dataclass(frozen=True)
class Recipe:
    """How a signal is made.

    Args:
        name: of the signal
        needs: the signals it is made from
        memory: how far back [s] it looks
        make: from the channels needed, in order, then the further ones, None where there is none
        further: signals that are used where a recording has them
    """

    name: str
    needs: tuple[str, ...]
    memory: float
    make: Callable[..., Channel]
    further: tuple[str, ...] = ()
