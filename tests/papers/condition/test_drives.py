"""The drives of the demonstrator: as many as the paper drives, faults where they are said to be, the same twice."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from tierod.vehicles import load
from tierod_lab.papers.condition import by_bank
from tierod_lab.papers.condition.drives import (
    ACTUATORS,
    OFFSET,
    SENSORS,
    Drive,
    Injected,
    actuator_tests,
    calibration_drives,
    changed_drives,
    healthy_drives,
    lost,
    mixed_pairs,
    more_kinds,
    sensor_pairs,
    sensor_tests,
    supply_tests,
)
from tierod_lab.papers.condition.recorded import TRUTHS, recorded
from tierod_lab.papers.condition.substitutes import _squares
from tierod_lab.papers.condition.vehicles import MEASURED, vehicle
from tierod_lab.studies.effort import Results


def test_the_tests_of_the_paper_are_48_and_9():
    sensors, actuators = sensor_tests(), actuator_tests()
    assert len(set(sensors)) == 48
    assert len(set(actuators)) == 9
    assert {each.injected[0].element for each in sensors} == set(SENSORS)
    assert {each.injected[0].element for each in actuators} == set(ACTUATORS)
    assert {each.course for each in sensors} == {"short-round", "long-round"}
    assert {each.seconds for each in actuators} == {200.0}
    both = {tuple(fault.element for fault in each.injected) for each in supply_tests(1, 0.5)}
    assert both == {ACTUATORS[:2], ACTUATORS[2:]}
    assert len(sensor_pairs()) == 30
    assert len(mixed_pairs()) == 24
    assert len(set(more_kinds(sizes=(0.5, 1.0)))) == 6 * (7 + 10)


def test_healthy_drives_take_the_hours_asked_for_on_rounds_that_no_calibration_has_seen():
    first, hour = calibration_drives()
    assert first.seconds == 300.0
    assert math.isclose(sum(each.seconds for each in hour), 3600.0)
    drives = healthy_drives(2.0)
    assert math.isclose(sum(each.seconds for each in drives), 7200.0)
    assert not {each.course for each in drives} & {each.course for each in (first, *hour)}
    assert all(not each.injected for each in (first, *hour, *drives))


def test_a_fault_of_a_sensor_changes_its_channel_alone_and_only_while_it_lasts():
    healthy = Drive("short-round", 8.0, seed=4)
    off = replace(healthy, injected=(Injected("yaw_rate", OFFSET, 0.3, 4.0, 6.0),))
    fault_free, faulty = recorded(healthy), recorded(off)
    time = fault_free["yaw_rate"].time
    during = (time >= 4.0) & (time < 6.0)
    np.testing.assert_allclose(faulty["yaw_rate"].values - fault_free["yaw_rate"].values, 0.3 * during, atol=1e-6)
    for name in (*MEASURED, *TRUTHS):
        if name != "yaw_rate":
            np.testing.assert_array_equal(faulty[name].values, fault_free[name].values)


def test_an_automated_driver_that_trusts_a_faulty_sensor_drives_otherwise():
    healthy = Drive("short-round", 8.0, seed=4)
    acted_on = replace(healthy, injected=(Injected("wheel_speed_rear_left", OFFSET, 2.0, 4.0, 8.0, in_the_loop=True),))
    fault_free, faulty = recorded(healthy), recorded(acted_on)
    assert faulty["truth_speed"].values[-1] < fault_free["truth_speed"].values[-1] - 0.3


def test_a_lost_motor_gives_no_torque_and_the_other_gives_more():
    drive = Drive("short-round", 12.0, injected=(lost("steering_motor_1", 1.0, 6.0, 12.0),))
    made = recorded(drive)
    late = made["yaw_rate"].time > 6.5
    assert np.max(np.abs(made["truth_steering_motor_1_torque"].values[late])) < 1e-6
    assert np.max(np.abs(made["truth_steering_motor_2_torque"].values[late])) > 5.0
    assert np.max(np.abs(made["truth_lateral_offset"].values)) < 1.0


def test_a_vehicle_that_changed_after_its_calibration_has_other_numbers_and_wheel_speeds():
    before, drives = vehicle(2), changed_drives(2.0, vehicles=(2,))
    assert {each.later for each in drives} == set(product(("mass", "stiffness", "radius"), (0.9, 1.1)))
    heavy, large = (next(each for each in drives if each.later == (name, 1.1)).driven for name in ("mass", "radius"))
    assert math.isclose(heavy.car.chassis.mass, 1.1 * before.car.chassis.mass)
    assert heavy.sensors == before.sensors
    assert math.isclose(large.sensors["wheel_speed_rear_left"].gain, before.sensors["wheel_speed_rear_left"].gain / 1.1)


def test_vehicles_differ_within_their_bands_and_are_the_same_when_drawn_again():
    nominal, drawn, again = vehicle(0), vehicle(3), vehicle(3)
    assert drawn == again
    mass = drawn.car.chassis.mass / nominal.car.chassis.mass - 1.0
    assert 0.04 <= abs(mass) <= 0.08
    gains = [drawn.sensors[f"wheel_speed_rear_{side}"].gain for side in ("left", "right")]
    assert 0.02 <= abs(1.0 / np.mean(gains) - 1.0) <= 0.055
    assert 0.0025 <= abs(gains[0] / gains[1] - 1.0) <= 0.0065


def test_what_is_made_of_a_drive_is_kept_by_all_that_decides_it(tmp_path):
    drive = Drive("round-3", 5.0, vehicle=2)
    known = by_bank.Known(load("smartload"))
    keys = Results(tmp_path)
    key = keys.key(partial(_squares, {2: known}), drive)
    assert key
    assert keys.key(partial(_squares, {2: by_bank.Known(load("smartload"))}), drive) == key
    assert keys.key(partial(_squares, {2: known}), replace(drive, seed=1)) != key


def test_the_demonstrator_turns_in_three_moves_backward_too():
    made = recorded(Drive("three-point-turn", 20.0, 0))
    speed, yaw, angle = (made[name].values for name in ("truth_speed", "truth_yaw_rate", "truth_steering_wheel_angle"))
    back = speed < -1.0
    assert back.sum() > 200
    assert np.all(np.sign(yaw[back]) == np.sign(speed[back] * angle[back]))
