"""Principal directions of what parameters do to a result."""

import numpy as np
import pytest

from tierod.monitors.harness.spread.directions import Sensitivities

TIME = np.linspace(0.0, 10.0, 1000)


def sensitivities(**moves):
    found = Sensitivities(tuple(moves))
    whole = np.array(list(moves.values()))
    for part in np.split(whole, 10, axis=1):
        found.add(part)
    return found


def test_two_parameters_with_one_course_are_one_direction():
    found = sensitivities(a=3.0 * np.sin(TIME), b=4.0 * np.sin(TIME)).directions(4)
    assert len(found) == 1
    assert found[0].share == pytest.approx(1.0)
    assert abs(found[0].by["a"] / found[0].by["b"]) == pytest.approx(0.75)
    assert sum(by * by for by in found[0].by.values()) == pytest.approx(1.0)


def test_unlike_courses_are_carried_apart_as_far_as_is_allowed():
    several = sensitivities(a=np.sin(TIME), b=np.cos(TIME), c=np.sin(5.0 * TIME))
    assert len(several.directions(4)) == 3
    assert len(several.directions(2)) == 2
    assert sum(each.share for each in several.directions(2)) < 0.85


def test_a_parameter_that_moves_nothing_is_in_no_direction():
    found = sensitivities(a=np.sin(TIME), b=0.01 * np.cos(TIME))
    assert set(found.directions(4)[0].by) == {"a"}
    assert sensitivities(a=0.01 * np.sin(TIME)).directions(4) == ()


def test_the_start_of_a_filter_does_not_count():
    late = np.where(TIME > 5.0, 1.0, 100.0)
    moves = sensitivities(a=late, b=np.where(TIME > 5.0, 2.0, 0.0)).moves()
    assert moves == pytest.approx({"a": 1.0, "b": 2.0}, rel=0.01)
