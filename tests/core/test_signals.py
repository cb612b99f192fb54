"""The catalogue of signals is consistent, and names of real recordings find their signal."""

import re
from math import isfinite

import pytest

from tierod.core.errors import InputError
from tierod.core.signals import SIGNALS, match, plain, signal
from tierod.core.units import scale, tidy


def test_every_signal_is_well_formed():
    for name, found in SIGNALS.items():
        assert found.name == name
        assert re.fullmatch(r"[a-z][a-z0-9_]*", name)
        assert found.meaning.endswith("."), name
        assert found.group, name
        assert found.plausible[0] < found.plausible[1], name
        assert tidy(found.unit) == found.unit, f"the unit of {name} is not written as pint writes it"
        assert scale(found.unit, found.unit).factor == 1.0, name


def test_no_alias_means_two_signals():
    owners: dict[str, set[str]] = {}
    for found in SIGNALS.values():
        for alias in (found.name, *found.aliases):
            owners.setdefault(plain(alias), set()).add(found.name)
    assert {alias: names for alias, names in owners.items() if len(names) > 1} == {}


@pytest.mark.parametrize(
    "name",
    [
        "steering_wheel_angle",
        "steering_wheel_rate",
        "driver_torque",
        "motor_torque",
        "yaw_rate",
        "lateral_acceleration",
        "vehicle_speed",
        "rack_position",
        "tie_rod_force",
        "sideslip_angle",
        "motor_angle_mechanical",
        "motor_angle_electrical",
        "motor_current_alpha",
        "motor_voltage_beta",
        "resolver_sine",
        "steering_motor_2_target_torque",
        "friction_torque",
        "self_aligning_torque",
        "bank_angle",
        "road_friction",
        *(f"wheel_speed_{end}_{side}" for end in ("front", "rear") for side in ("left", "right")),
    ],
)
def test_the_signals_of_the_five_domains_are_there(name):
    assert signal(name).name == name


@pytest.mark.parametrize(
    ("recorded", "meant"),
    [
        ("SW_pos_obd", "steering_wheel_angle"),
        ("LatAcc_obd", "lateral_acceleration"),
        ("VelRL_obd", "wheel_speed_rear_left"),
        ("STEER_TORQUE_SENSOR.STEER_TORQUE_DRIVER", "driver_torque"),
        ("RecStr.SlessIAlpha", "motor_current_alpha"),
        ("yawRate", "yaw_rate"),
        ("Servo motor speed", "motor_speed"),
        ("beta_true", "sideslip_angle"),
        ("steering wheel angle", "steering_wheel_angle"),
    ],
)
def test_names_of_real_recordings_find_their_signal(recorded, meant):
    found = match(recorded)
    assert found is not None
    assert found.name == meant


@pytest.mark.parametrize("recorded", ["id", "can_id", "forward", "INP", ""])
def test_other_names_find_none(recorded):
    assert match(recorded) is None


@pytest.mark.parametrize(
    ("recorded", "unit", "meant"),
    [
        ("Engine.Speed", "rpm", None),
        ("Engine.Speed", "", None),
        ("Engine.Speed", "count", None),
        ("Engine.Speed", "bananas", None),
        ("Wiper::v", "V", None),
        ("Seat/roll", "mm", None),
        ("Display\\yaw", "", None),
        ("Pump:mu", "", None),
        ("Vehicle.v", "km/h", "vehicle_speed"),
        ("Imu/yaw", "deg/s", "yaw_rate"),
        ("Tyre.mu", "%", "road_friction"),
        ("speed", "", "vehicle_speed"),
        ("Vehicle.Speed", "", "vehicle_speed"),
        ("Yaw.Rate", "", "yaw_rate"),
        ("ESP.YawRate", "", "yaw_rate"),
        ("Imu.ay", "", "lateral_acceleration"),
        ("Gps.heading", "", "heading"),
    ],
)
def test_a_general_word_behind_a_qualifier_needs_a_unit_that_fits(recorded, unit, meant):
    found = match(recorded, unit)
    assert (found and found.name) == meant


def test_the_last_part_of_a_longer_name_is_no_better():
    assert match("Speed", "rpm", qualified=True) is None
    assert match("Speed", "m/s", qualified=True) is signal("vehicle_speed")
    assert match("DriverTorque", "", qualified=True) is signal("driver_torque")


def test_a_wrong_name_gets_the_nearest_one():
    with pytest.raises(InputError, match="did you mean 'yaw_rate'"):
        signal("yaw_rat")


def test_plausible_ranges_hold_the_shipped_recordings_scale():
    assert all(isfinite(limit) for limit in signal("driver_torque").plausible)
