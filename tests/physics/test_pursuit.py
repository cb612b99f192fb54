import math

import pytest

from tierod.physics.pursuit import pursuit_curvature


@pytest.mark.parametrize("offset", [-0.5, 0.2])
def test_the_arc_meets_the_path_at_the_reach(offset):
    """On a circle that starts along the x axis, y = (1 - cos(s k)) / k."""
    curvature = pursuit_curvature(offset, 20.0)
    assert offset + (1.0 - math.cos(20.0 * curvature)) / curvature == pytest.approx(0.0, abs=1e-3)
