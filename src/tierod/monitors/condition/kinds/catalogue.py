"""The kinds of faults, by number, and what is estimated of one."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay", "loss of torque")
"""Kinds of faults, the last one of an actuator; the number of a kind is its place here plus one, 0 stands for none."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY, LOST_TORQUE = map(float, range(len(KINDS) + 1))


class Kind(NamedTuple):
    """The kind of a fault.

    Args:
        kind: number of the kind; 0 while nothing is declared
        magnitude: of an offset in the unit of the signal, of a gain or an outlier the factor, of a drift per second, of
            noise its standard deviation, of a delay in seconds; 0 of what has none
        deviation: standard deviation of the magnitude
        effect: what the fault adds to this reading at least, by all kinds that it may well be [unit of the signal];
            infinite where a reading that never changed moves again, and as it should
    """

    kind: Annotated[Scalar, ""]
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]
    effect: Annotated[Scalar, ""]
