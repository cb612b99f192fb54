"""Following a path by aiming at a point ahead."""

from __future__ import annotations

from tierod.core.block import Scalar


def pursuit_curvature(offset_ahead: Scalar, reach: Scalar) -> Scalar:
    """Curvature [1/m] of the arc that leads back to a straight path at a distance.

    Args:
        offset_ahead: lateral offset from the path that would be reached there on the present course, positive to the
            left [m]
        reach: distance [m], positive

    Source: pure pursuit; Amidi, Integrated Mobile Robot Control, CMU-RI-TR-90-17 (1990): 2 x / L^2.
    """
    return -2.0 * offset_ahead / (reach * reach)
