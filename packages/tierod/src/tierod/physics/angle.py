"""Angles modulo a full turn."""

from __future__ import annotations

import math

from tierod.core.block import Scalar
from tierod.core.graph.maths import floor


def wrapped(angle: Scalar) -> Scalar:
    """Angle wrapped to half a turn on either side of zero [rad].

    Args:
        angle: any number of turns [rad]

    Returns:
        from -pi (included) to pi (excluded) [rad]
    """
    return angle - 2.0 * math.pi * floor(angle / (2.0 * math.pi) + 0.5)
