import math
from types import SimpleNamespace

import numpy as np
import pytest

from ground.chassis.bench import STEP, drive
from tierod_lab.ground.cars.body import START, InertialUnit, moved, path_rate
from tierod_lab.ground.chassis import TwoTrack
from tierod_lab.ground.integration import runge_kutta

G = 9.81
UNIT = InertialUnit(forward=0.8, left=0.3, up=-0.4)


def turned(about, angle):
    """Rotation matrices about the x or the z axis, shape (n, 3, 3)."""
    cosine, sine, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    x = [[one, zero, zero], [zero, cosine, -sine], [zero, sine, cosine]]
    z = [[cosine, -sine, zero], [sine, cosine, zero], [zero, zero, one]]
    return np.moveaxis(np.array(x if about == "x" else z), -1, 0)


def integral(rate):
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * STEP)])


def specific_force(out):
    """What a weightless mass feels at the unit: from the place of the unit in space, differentiated twice [m/s**2]."""
    yaw = integral(out["reaction.yaw_rate"])
    over_ground = (
        turned("z", yaw)
        @ np.stack([out["reaction.speed"], out["reaction.lateral_speed"], np.zeros(len(yaw))], axis=-1)[..., None]
    )
    centre = np.stack([integral(over_ground[:, axis, 0]) for axis in range(3)], axis=-1)
    axes = turned("z", yaw) @ turned("x", out["reaction.roll_angle"])
    place = centre + axes @ np.array([UNIT.forward, UNIT.left, UNIT.up])
    acceleration = np.gradient(np.gradient(place, STEP, axis=0), STEP, axis=0)
    return np.einsum("nji,nj->ni", axes, acceleration + np.array([0.0, 0.0, G]))


def test_it_feels_what_its_motion_through_space_says():
    out = drive(TwoTrack(), 6.0, 20.0, steer=lambda t: 0.06 * np.sin(5.0 * t) * np.minimum(t, 1.0), brake=150.0)
    parts = (name for name in out.names if name.startswith("reaction."))
    reaction = SimpleNamespace(**{name.removeprefix("reaction."): out[name] for name in parts})
    lateral, longitudinal = UNIT.lateral_acceleration(reaction), UNIT.longitudinal_acceleration(reaction)
    felt = specific_force(out)[1000:-10]
    assert np.max(np.abs(felt[:, 1])) > 3.0
    assert lateral[1000:-10] == pytest.approx(felt[:, 1], abs=0.05)
    assert longitudinal[1000:-10] == pytest.approx(felt[:, 0], abs=0.05)


def test_standing_on_a_slope_it_feels_gravity_alone():
    out = drive(TwoTrack(), 20.0, 0.0, brake=800.0, bank=0.06, grade=0.08).at(-1).reaction
    assert UNIT.lateral_acceleration(out) == pytest.approx(G * (math.sin(0.06) + out.roll_angle), rel=1e-3)
    assert out.roll_angle > 0.0
    assert UNIT.longitudinal_acceleration(out) == pytest.approx(G * math.sin(0.08), rel=1e-3)


RADIUS = 40.0


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
