"""The kinds of faults of sensors, by number, and what is said of one."""

from __future__ import annotations

from typing import Annotated, NamedTuple

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay")
"""Kinds of faults of a sensor; the number of a kind is its place here plus one, 0 stands for none."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY = (float(number) for number in range(9))


class Kind(NamedTuple):
    """The kind of a fault.

    Args:
        kind: number of the kind; 0 while nothing is declared
        size: of an offset in the unit of the signal, of a gain or an outlier the factor, of a drift per second, of
            noise its standard deviation, of a delay in seconds; 0 of what has none
        deviation: standard deviation of the size
        effect: what the fault adds to this reading at least, by all kinds that it may well be [unit of the signal];
            infinite where a reading that never changed moves again, and as it should
    """

    kind: Annotated[float, ""]
    size: Annotated[float, ""]
    deviation: Annotated[float, ""]
    effect: Annotated[float, ""]
