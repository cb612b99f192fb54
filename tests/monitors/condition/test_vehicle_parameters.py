"""Calibration of the condition monitor's vehicle on healthy driving."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.parameters import FREE, Point, Search, WhitenedInnovations, _free, calibrate
from tierod.monitors.condition.vehicle_filter import SENSOR_NOISE, LeaveOutFilter
from tierod.vehicles import load
from tierod.vehicles.vehicle import QUANTITIES
from tierod_lab.papers.condition.drives import Drive, calibration_drives, vehicle
from tierod_lab.papers.condition.recorded import recorded

CAR = load("smartload")


def test_whitened_innovations_make_up_the_likelihood_of_the_filter():
    samples = aligned(recorded(Drive("short-round", 24.0, 0, 5)))[:1000]
    lane = replace(LeaveOutFilter.of_vehicle(CAR), influence=1e3)
    values = scan(WhitenedInnovations(lane), samples, engine="virtual machine").values
    constant = sum(math.log(each) + 0.5 * math.log(2.0 * math.pi) for each in lane.sensor_noise)
    ours = -0.5 * np.sum(values[:, :8] ** 2, axis=1) - np.sum(values[:, 8:], axis=1) - constant
    theirs = scan(lane, samples)["log_likelihood"]
    np.testing.assert_allclose(theirs[60:], ours[60:], atol=1e-3)
    assert np.all(theirs[:40] == 0.0)


def test_a_short_drive_is_refused_with_what_would_do():
    recording = recorded(Drive("short-round", 24.0, 0, 5))
    with pytest.raises(InputError, match="better five minutes with bends"):
        calibrate([recording], CAR)


def test_a_vehicle_without_deviations_is_refused():
    known = {name: replace(each, standard_deviation=None) for name, each in CAR.parameters.items()}
    with pytest.raises(InputError, match="gives no standard deviation"):
        Search(replace(CAR, parameters=known), [], FREE)


def test_the_search_stays_within_what_is_plausible():
    search = Search(CAR, [], FREE)
    lowest, highest = (search.centre + search.scale * each for each in (search.least, search.most))
    for name, low, high in zip(search.names, lowest, highest, strict=True):
        assert (low, high) == pytest.approx(QUANTITIES[name].plausible)
    count = len(search.names)
    search.most = np.full(count, 0.1)
    search.at = lambda place: Point(1e9, np.full(count, -1e9), np.eye(count), [], np.ones(8), 1)
    search.cost = lambda place: -float(np.sum(place))
    place, *_ = search._descend(np.zeros(count))
    np.testing.assert_allclose(place, 0.1)


def test_one_rear_wheel_alone_is_not_asked_what_the_other_reads():
    both = np.zeros((10, 14))
    one = both.copy()
    one[:, 0] = np.nan
    assert _free([both, one]) == FREE
    assert set(FREE).difference(_free([one, one])) == {"wheel_speed_difference"}


@pytest.mark.slow
def test_five_minutes_distinguish_the_vehicle_and_its_sensors_from_the_nominal_ones():
    found = calibrate([recorded(calibration_drives(1)[0])], CAR)
    assert found.found.converged
    assert found.found.after > found.found.before
    assert not found.vehicle.parameters["wheel_speed_scale"].assumed
    car, sensors = vehicle(1)
    left, right = sensors["wheel_speed_rear_left"].gain, sensors["wheel_speed_rear_right"].gain
    assert found.vehicle["mass"] == pytest.approx(car.chassis.mass, rel=0.02)
    assert found.vehicle["wheel_speed_scale"] == pytest.approx(0.5 * (left + right), rel=0.006)
    assert found.vehicle["wheel_speed_difference"] == pytest.approx(right / left - 1.0, abs=3e-4)
    assert found.vehicle["nominal_friction"] == pytest.approx(car.steering.rack.friction.level, rel=0.02)
    assert found.vehicle["rack_damping"] == pytest.approx(car.steering.rack.rack_damping, rel=0.02)
    assert found.vehicle["rack_stiffness"] == pytest.approx(car.steering.rack.centring, rel=0.02)
    for name, close in (("yaw_rate", 5e-4), ("steering_shaft_torque", 0.01), ("tie_rod_force", 1.5)):
        assert found.vehicle[f"{name}_offset"] == pytest.approx(sensors[name].bias, abs=close)
    noise = LeaveOutFilter.of_vehicle(found.vehicle).sensor_noise
    assert noise.tie_rod_force == pytest.approx(SENSOR_NOISE.tie_rod_force, rel=0.01)
