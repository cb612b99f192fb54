import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.proving_ground import FrictionCourse


def level(course, *time):
    """What the fault makes of the parameter at some instants [s]."""
    change = course.behaviour().change(np.array(time), None)
    assert change.gain == 0.0
    return change.offset


def test_constant_step_and_ramp():
    time = (0.0, 9.999, 10.0, 15.0, 20.0, 30.0)
    np.testing.assert_array_equal(level(FrictionCourse.constant(4.0), *time), 4.0)
    np.testing.assert_array_equal(level(FrictionCourse.step(4.0, 8.0, 10.0), *time), [4, 4, 8, 8, 8, 8])
    np.testing.assert_allclose(level(FrictionCourse.ramp(4.0, 8.0, 10.0, 20.0), *time), [4, 4, 4, 6, 8, 8])


def test_several_corners():
    course = FrictionCourse((0.0, 10.0, 10.0, 20.0), (4.0, 4.0, 6.0, 8.0))
    np.testing.assert_allclose(level(course, 5.0, 10.0, 15.0, 99.0), [4, 6, 7, 8])


@pytest.mark.parametrize(
    ("times", "levels", "message"),
    [
        ((), (), "one level per time"),
        ((0.0, 1.0), (4.0,), "one level per time"),
        ((1.0, 0.0), (4.0, 5.0), "backwards"),
        ((1.0, 1.0, 1.0), (4.0, 5.0, 6.0), "three corners at one instant"),
        ((0.0,), (-1.0,), "not negative"),
        ((0.0,), (float("nan"),), "finite"),
    ],
)
def test_impossible_courses_are_refused(times, levels, message):
    with pytest.raises(ParameterError, match=message):
        FrictionCourse(times, levels)
