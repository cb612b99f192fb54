"""The catalogue of signals is consistent, and names of real recordings find their signal."""

from __future__ import annotations

import math
import re
from math import isfinite

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.signals import SIGNALS, UNBOUNDED, levels_of, match, plain, residue_between, residue_of, signal
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


WHEEL = SIGNALS["steering_wheel_angle"].plausible[1]


def test_single_precision_of_a_plausible_reading_is_a_residue_and_a_step_of_a_sensor_is_none():
    for reading in np.linspace(-WHEEL, WHEEL, 101).tolist():
        assert abs(float(np.float32(reading)) - reading) < residue_of("steering_wheel_angle")
    assert residue_of("steering_wheel_angle") < 0.01 * math.radians(0.1)


def test_a_signal_without_a_plausible_range_has_residues_all_the_same():
    assert 0.0 < residue_of("motor_angle_mechanical") < 1e-6 * UNBOUNDED


def test_a_small_motion_far_from_zero_is_no_residue():
    assert residue_between(5e6, 5e6 + 0.02) < 0.01
    assert residue_between(5.0, 5.0 + 4e-15) > 4e-15
    assert residue_between(5.0, 5.0 + 1e-9) < 1e-9
    assert residue_between(0.0, 0.0) == 0.0


def test_levels_are_counted_without_their_residues():
    values = np.array([0.3, 0.1 + 0.2, 1.0, -2.0, 1.0 + 1e-13, 1.0 - 1e-13])
    levels, counts = levels_of(values, residue_between(-2.0, 1.0))
    assert levels == pytest.approx([-2.0, 0.3, 1.0])
    assert counts.tolist() == [1, 2, 3]
    assert not len(levels_of(np.array([]), 1e-9)[0])
