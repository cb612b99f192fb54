"""Limits on the unpacked size of a recording: a file of some megabytes can hold gigabytes of zeros."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tierod.core.errors import InputError, ParameterError

# Environment variable that raises (or lowers) `Limits.largest`: a number of bytes, or one with kB, MB or GB
VARIABLE = "TIEROD_LARGEST"

_UNITS = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "kib": 2**10, "mib": 2**20, "gib": 2**30}


@dataclass(frozen=True)
class Limits:
    """Limits of the unpacked size of a recording, as text as well as in samples of eight bytes."""

    # unpacked size that any recording may have [byte]: ten hours at 100 Hz of 37 channels, as samples
    largest: Annotated[int, "byte"] = 10**9 + 10**8
    # largest ratio of unpacked to packed size beyond that; packed recordings of cars stay below 30, zeros reach
    # 1000
    ratio: Annotated[float, ""] = 100.0
    # size of one line of text [byte]: 10 000 columns of numbers with 16 digits take 0.2 MB
    line: Annotated[int, "byte"] = 1 << 22
    # size of one packed block that must be unpacked as a whole [byte]; recorders write 0.1 to 4 MB
    block: Annotated[int, "byte"] = 1 << 27


def limits() -> Limits:
    """The limits in effect."""
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return Limits()
    match = re.fullmatch(r"(\d{1,15}(?:\.\d{1,6})?)\s*([a-zA-Z]{0,3})", text)
    if match is None or match[2].lower() not in _UNITS:
        raise ParameterError(f"{VARIABLE} = {text[:40]!r} is not a size; write bytes, or for example 4GB")
    size = int(float(match[1]) * _UNITS[match[2].lower()])
    return Limits(largest=size, block=max(size // 8, Limits.block))


class Allowance:
    """Counts the unpacked size of a file, and stops where it exceeds the limits.

    Args:
        size: size of the stored file [bytes]
    """

    def __init__(self, path: Path | str, size: int):
        self.path, self.size = path, size
        self.limits = limits()
        self.most = max(self.limits.largest, int(self.limits.ratio * size))
        self.taken = 0

    def take(self, count: int) -> None:
        """Count further bytes."""
        self.taken += count
        if self.taken > self.most:
            raise self.refused(f"more than {self.most / 1e9:.3g} GB")

    def take_block(self, count: int) -> None:
        """Check the size of one packed block before it is unpacked."""
        if count > self.limits.block:
            raise self.refused(f"a block of {count / 1e9:.3g} GB, where {self.limits.block / 1e9:.3g} GB are the limit")

    def refused(self, what: str) -> InputError:
        """The error for a file whose unpacked size is too large."""
        return InputError(
            f"{self.path} takes {self.size / 1e6:.3g} MB and unpacks to {what}; if the file is intact, raise the "
            f"limit: set the environment variable {VARIABLE}, for example {VARIABLE}="
            f"{max(round(4e-9 * self.most), 4)}GB"
        )
