import math

import pytest

from tierod.physics.single_track import steady_road_wheel_angle
from tierod_lab.ground.control.automated import AutomatedDriver, Sensed, Split
from tierod_lab.ground.parts import Demand, Hand, Intent, Seen

DRIVER = AutomatedDriver(target_rate=1e6)
ON_THE_PATH = Seen(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Hand(0.0, 0.0))
STRAIGHT = Demand(8.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
CRUISING = Sensed(8.0, 0.0, 0.0)


def targets(driver=DRIVER, place=ON_THE_PATH, demand=STRAIGHT, sensed=CRUISING):
    return driver.command(driver.reset(), place, demand, sensed)[1]


def test_on_a_straight_path_nothing_is_asked_for():
    wanted = targets()
    assert wanted.steering_wheel_angle == wanted.steering_torque_1 == wanted.steering_torque_2 == wanted.force == 0.0
    assert wanted.speed == 8.0


def test_a_bend_ahead_is_steered_as_the_single_track_needs():
    steer = math.atan(steady_road_wheel_angle(0.05, 8.0, DRIVER.wheelbase, DRIVER.understeer_gradient))
    bend = targets(demand=STRAIGHT._replace(curvature_ahead=0.05), place=ON_THE_PATH._replace(curvature=0.05),
                   sensed=CRUISING._replace(yaw_rate=0.4))  # fmt: skip
    assert bend.steering_wheel_angle == pytest.approx(19.7 * steer)


@pytest.mark.parametrize("place", [ON_THE_PATH._replace(lateral_offset=0.3), ON_THE_PATH._replace(lateral_speed=0.3)])
def test_offset_and_course_are_corrected_only_where_there_is_a_path(place):
    assert targets(place=place).steering_wheel_angle < 0.0
    assert targets(place=place, demand=STRAIGHT._replace(attention=0.0)).steering_wheel_angle == 0.0


def test_too_much_yaw_rate_is_steered_against():
    assert targets(sensed=CRUISING._replace(yaw_rate=0.1)).steering_wheel_angle == pytest.approx(-0.1 * 0.03 * 19.7)


def test_the_target_turns_no_faster_than_asked():
    slow = AutomatedDriver(target_rate=8.0)
    assert targets(slow, demand=STRAIGHT._replace(steering_wheel_angle=1.0)).steering_wheel_angle == pytest.approx(8e-3)


def test_speed_comes_from_the_sensors():
    late = targets(sensed=CRUISING._replace(speed=7.0))
    assert late.force == pytest.approx(DRIVER.mass * DRIVER.speed_control.proportional)


def test_motors_share_the_torque_and_wheels_help_if_asked():
    helped = AutomatedDriver(split=Split(0.6, 0.1, 0.24), drive_steering=50.0)
    wanted = targets(helped, sensed=CRUISING._replace(steering_wheel_angle=-0.1))
    total = wanted.steering_torque_1 + wanted.steering_torque_2
    assert total > 0.0
    assert wanted.steering_torque_1 == pytest.approx(0.7 * total)
    assert wanted.drive_difference == pytest.approx(50.0 * total)


def test_the_split_swings_about_its_mean():
    split = Split(0.5, 0.15, 0.24)
    assert split.first(0.0) == split.first(0.11) == pytest.approx(0.65)
    assert split.first(0.12) == split.first(0.23) == pytest.approx(0.35)


def test_it_has_neither_hands_nor_feet_and_sees_how_the_offset_grows():
    seen = Seen(8.0, 0.0, 0.2, 0.1, 0.3, 0.05, 0.02, Hand(0.1, 0.0))
    assert DRIVER.decide((), seen, STRAIGHT) == ((), Intent(0.0, 0.0))
    assert seen.offset_rate == pytest.approx(8.0 * 0.05 + 0.2)
    assert DRIVER.hand_torque((), Hand(1.0, 1.0), STRAIGHT) == 0.0
