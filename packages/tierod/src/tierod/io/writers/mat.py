"""MATLAB 5: a vector "time" with the signals, or one structure of these per group of channels with common stamps."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.io.layout import Writer
from tierod.io.writers.spool import FromSpool, Spool, SpooledGroup

_LONGEST = 63  # Largest number of characters of a name in MATLAB
_LARGEST = 2**31 - 1024  # Largest size of a vector in a MATLAB 5 file [bytes]
UNITS = "units"  # Name of the structure of texts with the unit of every vector


def write_mat(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to a file for MATLAB's `load`, not packed.

    Args:
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold
    """
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    found = spool.groups()
    names = _names(list(spool.channels))
    lost = ["MATLAB 5 holds units (in the structure 'units'), but no sources, notes or calendar time"]
    renamed = [f"{name} is {names[name]}" for name in spool.channels if names[name] != name]
    if renamed:
        lost.append(f"names that MATLAB does not allow were changed: {', '.join(renamed[:6])}")
    for group in found:
        if 8 * group.count > _LARGEST:
            raise OutputError(
                f"'{group.channels[0].name}' has {group.count} samples, more than a MATLAB 5 file holds; "
                "write Parquet or MF4"
            )
    units = {names[name]: each.unit for name, each in spool.channels.items()}
    with replacing(path) as temporary, temporary.open("wb") as file:
        # Vectors of one group are written one by one, so that only one of them is in memory.
        parts = _vectors(found[0], names) if len(found) == 1 else _structures(found, names)
        try:
            for name, value in (*parts, (UNITS, units)):
                savemat(file, {name: value}, long_field_names=True, oned_as="column")
        except MatWriteError as error:
            raise OutputError(f"{path} cannot be written as MATLAB 5 ({error}); write Parquet or MF4") from None
    return tuple(lost)


def _vectors(group: SpooledGroup, names: dict[str, str]) -> Iterator[tuple[str, np.ndarray]]:
    yield "time", group.time(0, group.count)
    for place, channel in enumerate(group.channels):
        yield names[channel.name], group.column(place)


def _structures(groups: tuple[SpooledGroup, ...], names: dict[str, str]) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    for number, group in enumerate(groups):
        yield f"group{number + 1}", dict(_vectors(group, names))


def _names(given: list[str]) -> dict[str, str]:
    """A name that MATLAB allows for every channel: unique, and different from "time" and "units"."""
    taken, found = {"time", UNITS}, {}
    for name in given:
        base = re.sub(r"[^A-Za-z0-9_]", "_", name)[:_LONGEST]
        base = base if base[:1].isalpha() else f"x{base}"[:_LONGEST]
        free = (base, *(f"{base[: _LONGEST - 7]}_{number}" for number in range(2, len(given) + 4)))
        found[name] = next(each for each in free if each not in taken)
        taken.add(found[name])
    return found


WRITER = Writer("MATLAB 5", FromSpool(write_mat))
