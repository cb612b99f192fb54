"""What is foreseen of a car's way has no jumps, and is right for a steady acceleration."""

import numpy as np
import pytest

from tierod.proving_ground.run import Foresight

LOOK = 0.2
TIME = np.linspace(0.0, LOOK, 50, endpoint=False)


def pieces(foresight, distance_at, speed_at, count):
    """Distances and speeds of several looks, one after the other."""
    found = []
    for number in range(count):
        if number:
            now = number * LOOK
            foresight.look(distance_at(now), speed_at(now), LOOK)
        found.append(foresight.over(TIME, LOOK))
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def test_a_steady_speed_is_foreseen_exactly():
    distance, speed = pieces(Foresight(0.0, 8.0), lambda t: 8.0 * t, lambda t: 8.0, 4)
    assert distance == pytest.approx(8.0 * np.arange(200) * LOOK / 50)
    assert np.all(speed == 8.0)


def test_a_steady_braking_is_foreseen_from_the_third_look_on():
    distance, speed = pieces(Foresight(0.0, 10.0), lambda t: 10.0 * t - 1.5 * t * t, lambda t: 10.0 - 3.0 * t, 5)
    time = np.arange(250) * LOOK / 50
    assert distance[150:] == pytest.approx(10.0 * time[150:] - 1.5 * time[150:] ** 2)
    assert speed[150:] == pytest.approx(10.0 - 3.0 * time[150:])


def test_a_look_that_corrects_makes_no_jump():
    rng = np.random.default_rng(1)
    speeds = 8.0 + np.cumsum(rng.normal(0.0, 0.5, 20))
    places = np.concatenate([[0.0], np.cumsum(speeds[:-1] * LOOK)])

    def at(values):
        return lambda now: float(values[round(now / LOOK)])

    distance, speed = pieces(Foresight(0.0, float(speeds[0])), at(places), at(speeds), 20)
    assert np.abs(np.diff(distance, 2)).max() < 0.01
    assert np.abs(np.diff(speed)).max() < 0.15
    assert np.abs(np.diff(places, 2)).max() > 0.1  # the looks themselves jump
