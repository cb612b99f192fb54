import math
from types import SimpleNamespace

import pytest

from tierod.proving_ground.cars.body import START, moved, path_rate
from tierod.proving_ground.integration import runge_kutta

RADIUS, STEP = 40.0, 1e-3


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_car_that_wanders_about_a_circle_is_where_geometry_says(side):
    path, position = START._replace(lateral_offset=1.5, heading_error=0.1, heading=0.1), (0.0, 1.5)
    for k in range(8000):
        time = k * STEP
        reaction = SimpleNamespace(
            speed=12.0 + math.sin(time),
            lateral_speed=0.4 * math.cos(2.0 * time),
            yaw_rate=side * 0.3 + 0.1 * math.sin(time),
        )
        position = moved(position, reaction, path.heading, STEP)
        path = runge_kutta(lambda now, at=reaction: path_rate(now, at, side / RADIUS), path, STEP)
    outward, along = position[1] - side * RADIUS, position[0]
    turned = math.atan2(along, -side * outward) % (2.0 * math.pi)
    assert path.distance == pytest.approx(RADIUS * turned, abs=0.02)
    assert path.lateral_offset == pytest.approx(side * (RADIUS - math.hypot(along, outward)), abs=0.02)
    assert path.heading_error == pytest.approx(path.heading - side * turned, abs=1e-3)


def test_far_inside_a_bend_the_distance_stays_finite():
    reaction = SimpleNamespace(speed=10.0, lateral_speed=0.0, yaw_rate=0.0)
    assert path_rate(START._replace(lateral_offset=40.0), reaction, 1.0 / RADIUS).distance == pytest.approx(50.0)
