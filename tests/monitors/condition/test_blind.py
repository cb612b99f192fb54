"""What a missing sensor costs, in sentences."""

import pytest

from tierod.core.errors import ParameterError
from tierod.monitors.condition.blind import limitations
from tierod.monitors.condition.structure import rolls, vehicle_structure
from tierod.vehicles import load, shipped


def test_with_four_sensors_every_single_fault_of_a_car_is_told():
    (told,) = limitations(load("rav4"), ["steering_shaft_torque", "tie_rod_force"])
    assert told.startswith("without steering shaft torque and tie rod force, single faults of wheel speed rear left")
    assert told.endswith("are still told apart by the equations")


def test_without_yaw_rate_and_accelerations_nobody_knows_which_of_three_it_is():
    missing = ["yaw_rate", "longitudinal_acceleration", "lateral_acceleration"]
    first, pairs = limitations(load("revsted-car"), missing)
    alike = "wheel speed rear left, wheel speed rear right and steering wheel angle are not told apart"
    assert first.endswith(f"faults of {alike}")
    assert pairs.startswith("of 3 pairs of faults 3 are not told from others")


def test_a_single_sensor_is_checked_by_nothing():
    missing = ["wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle", "longitudinal_acceleration"]
    told = limitations(load("rav4"), [*missing, "lateral_acceleration"])
    assert told[0].endswith("faults of wheel speed rear left do not show in any equation")


def test_the_steering_motors_stay_alike_without_their_torque():
    told = limitations(load("smartload"), ["steering_shaft_torque"])
    assert (
        told[0] == "without steering shaft torque, faults of steering motor 1 and steering motor 2 are not told apart"
    )


def test_cars_without_torques_are_told_what_their_motion_lacks_and_nothing_else():
    assert {name for name in ("rav4", "revsted-car", "smartload") if rolls(load(name))} == {"rav4", "revsted-car"}
    assert "ferrari-250lm" in shipped()
    with pytest.raises(ParameterError, match=r"lacks track_width\. "):
        vehicle_structure(load("ferrari-250lm"))
