"""Hold of inputs that are missing now and then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tierod.methods.filters.each import EachSignal


@dataclass(frozen=True)
class InputHold(EachSignal):
    """Bridge missing samples with the last value; comes before an estimator whose inputs must be present.

    The arguments are those of `EachSignal`. Present samples pass unchanged; a signal that is missing for longer than
    `maximum_gap` comes out as missing (NaN), and so it does before its first sample.
    """

    def _settled(self, value: Any) -> tuple[()]:
        return ()

    def _advance(self, memory: tuple[()], value: Any) -> tuple[tuple[()], Any]:
        return memory, value
