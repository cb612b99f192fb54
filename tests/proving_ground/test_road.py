import numpy as np
import pytest

from tierod.proving_ground import CITY, COUNTRY, MIXED, MOTORWAY, random_road


@pytest.mark.parametrize("kinds", [MIXED, (CITY,), (COUNTRY,), (MOTORWAY,)])
@pytest.mark.parametrize("seed", range(3))
def test_speed_keeps_comfort_acceleration_and_braking(kinds, seed):
    road = random_road(600.0, np.random.default_rng(seed), kinds)
    assert road.time[-1] > 600.0
    assert np.all(np.diff(road.time) > 0.0)
    lateral = road.speed**2 * np.abs(road.curvature)
    assert np.max(lateral) <= max(kind.lateral_acceleration for kind in kinds) * (1.0 + 1e-9)
    longitudinal = np.diff(road.speed**2) / (2.0 * np.diff(road.distance))
    assert longitudinal.max() <= 1.5 + 1e-6
    assert longitudinal.min() >= -2.0 - 1e-6


def test_both_directions_are_turned():
    road = random_road(780.0, np.random.default_rng(0))
    left = np.sum(np.maximum(road.curvature, 0.0))
    right = np.sum(np.maximum(-road.curvature, 0.0))
    assert 0.5 < left / right < 2.0


def test_curvature_has_no_steps():
    road = random_road(780.0, np.random.default_rng(0), (COUNTRY,))
    assert np.max(np.abs(np.diff(road.curvature))) < 0.1 * np.max(np.abs(road.curvature))


def test_long_drive_repeats_the_kinds():
    road = random_road(3600.0, np.random.default_rng(0))
    assert road.kinds[:6] == ("city", "country", "motorway") * 2
    assert list(road.starts) == sorted(road.starts)


def test_same_generator_same_road():
    one, again = (random_road(100.0, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(one.curvature, again.curvature)
