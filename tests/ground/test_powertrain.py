import math
from typing import NamedTuple

import pytest

from tierod_lab.ground.parts import Wheels
from tierod_lab.ground.powertrain import Powertrain, WheelMotors


class Moving(NamedTuple):
    speed: float
    spinning: float = 0.0

    @property
    def wheel_speeds(self) -> Wheels:
        return Wheels(self.speed, self.speed, self.speed, self.speed + self.spinning)


def test_drive_goes_to_the_driven_axle_and_gives_the_force():
    drive, brakes = Powertrain(front_share=1.0).torques(2000.0, Moving(10.0))
    assert sum(drive) / 0.31 == pytest.approx(2000.0)
    assert drive.rear_left == drive.rear_right == 0.0
    assert sum(brakes) == 0.0


def test_brakes_are_shared_and_limited():
    drive, brakes = Powertrain().torques(-5000.0, Moving(10.0))
    assert sum(drive) == 0.0
    assert sum(brakes) / 0.31 == pytest.approx(5000.0)
    assert (brakes.front_left + brakes.front_right) / sum(brakes) == pytest.approx(0.68)
    _, hard = Powertrain().torques(-1e6, Moving(10.0))
    assert sum(hard) / 0.31 == pytest.approx(18e3)


def test_power_limits_the_force_at_speed():
    train = Powertrain(greatest_drive_force=7000.0, greatest_power=110e3)
    assert sum(train.torques(1e6, Moving(0.0))[0]) / 0.31 == pytest.approx(7000.0)
    assert sum(train.torques(1e6, Moving(50.0))[0]) / 0.31 == pytest.approx(2200.0)


def test_a_wheel_that_spins_takes_the_power_from_the_car():
    train = Powertrain(front_share=0.0, greatest_drive_force=7000.0, greatest_power=110e3)
    drive, _ = train.torques(1e6, Moving(10.0, spinning=60.0))
    assert sum(drive) / 0.31 == pytest.approx(110e3 / 40.0)
    power = sum(each * speed for each, speed in zip(drive, (10.0, 10.0, 10.0, 70.0), strict=True)) / 0.31
    assert power == pytest.approx(110e3)
    assert sum(Powertrain().torques(2000.0, Moving(10.0, spinning=60.0))[0]) / 0.31 == pytest.approx(2000.0)


def test_the_limiter_leaves_no_torque_beyond_the_greatest_speed():
    train = Powertrain(front_share=0.0, greatest_speed=70.0)
    half, whole = (sum(train.torques(1e6, Moving(speed))[0]) / 0.31 for speed in (0.975 * 70.0, 66.5))
    assert half == pytest.approx(0.5 * 110e3 / 68.25)
    assert whole == pytest.approx(110e3 / 66.5)
    assert sum(train.torques(1e6, Moving(10.0, spinning=130.0))[0]) == 0.0


def test_wheel_motors_share_force_and_difference():
    left, right = WheelMotors().requests(400.0, 20.0, Moving(2.0))
    assert (left + right) / 0.243 == pytest.approx(400.0)
    assert right - left == pytest.approx(20.0)


def test_wheel_motors_stay_within_torque_and_power():
    motors = WheelMotors()
    assert motors.requests(1e5, 0.0, Moving(0.0)) == (160.0, 160.0)
    bound = 6e3 * 0.243 / 20.0
    assert motors.requests(1e5, 0.0, Moving(20.0)) == pytest.approx((bound, bound))


def test_friction_brakes_give_what_the_motors_lack():
    motors = WheelMotors()
    drive, brakes = motors.torques(-2000.0, Moving(20.0))
    assert -sum(drive) / 0.243 + sum(brakes) / 0.243 == pytest.approx(2000.0)
    assert sum(brakes) > 0.0
    _, lost = motors.wheels(0.0, 0.0, -2000.0)
    assert sum(lost) / 0.243 == pytest.approx(2000.0)
    _, driving = motors.wheels(50.0, 0.0, 200.0)
    assert sum(driving) == 0.0
    assert not math.copysign(1.0, driving.front_left) < 0.0
