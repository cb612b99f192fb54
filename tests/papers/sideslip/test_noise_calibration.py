"""Noises fitted together with a parameter, on a small virtual truth."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.recording import Channel, Recording
from tierod.monitors.sideslip.tuning import tuning_of
from tierod.vehicles import load
from tierod_lab.papers.sideslip import noise_calibration
from tierod_lab.papers.sideslip.calibration import beside_truth
from tierod_lab.papers.sideslip.noise_calibration import HELD, START, calibrated_with_noises, with_noises

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

CAR = load("midsize-eps")
TIME = np.arange(2000) / 100.0


def drive():
    rng = np.random.default_rng(4)
    steer = 0.04 * np.sin(0.9 * TIME)
    noise = rng.normal(0.0, 1.0, (3, len(TIME)))
    values = {
        "vehicle_speed": (np.full(len(TIME), 20.0), "m/s"),
        "steering_wheel_angle": (steer / CAR["steering_ratio"], "rad"),
        "yaw_rate": (5.0 * steer + 0.003 * noise[0], "rad/s"),
        "lateral_acceleration": (100.0 * steer + 0.3 * noise[1], "m/s**2"),
        "longitudinal_acceleration": (np.zeros(len(TIME)), "m/s**2"),
        "sideslip_angle": (-0.6 * steer + 0.003 * noise[2], "rad"),
    }
    return Recording({name: Channel(name, TIME, value, unit) for name, (value, unit) in values.items()})


def test_noises_are_found_and_scaled_until_the_band_holds(monkeypatch):
    monkeypatch.setattr(noise_calibration, "EVALUATIONS", 3)
    found = calibrated_with_noises(drive(), CAR, ("rear_cornering_stiffness",))
    assert set(START) | set(HELD) <= set(found.parameters)
    assert found.parameters["yaw_rate_drift"].unit == "rad/s**1.5"
    assert tuning_of(found).yaw_adaptation == 0.0
    before, after = (beside_truth(drive(), each).figures(1.0) for each in (CAR, found))
    assert after.rms < before.rms
    assert 0.85 < after.coverage < 0.99


def test_a_noise_that_a_file_lacks_is_added_with_the_unit_of_the_catalogue():
    found = with_noises(CAR, {"bank_wander": 0.02, "mass": 1500.0})
    assert found.parameters["bank_wander"].unit == "rad"
    assert found.parameters["mass"].standard_deviation == CAR.parameters["mass"].standard_deviation
    assert math.isclose(found["mass"], 1500.0)


def test_a_parameter_without_a_standard_deviation_is_not_fitted():
    with pytest.raises(ParameterError, match="tyre_friction"):
        calibrated_with_noises(drive(), CAR, ("tyre_friction",))


@pytest.mark.parametrize(("deviations", "factor"), [(1.96, 1.0), (3.92, 2.0), (100.0, 5.0), (0.01, 0.2)])
def test_the_noises_are_scaled_as_far_as_the_band_needs_but_no_further(monkeypatch, deviations, factor):
    """A normal error lies within 1.96 deviations in 95 of 100 cases; five times is where a drive is no measure."""
    time = np.arange(4000) / 100.0
    seen = SimpleNamespace(time=time, error=np.full(4000, 0.01 * deviations), deviation=np.full(4000, 0.01))
    monkeypatch.setattr(noise_calibration, "beside_truth", lambda *_: seen)
    found = calibrated_with_noises(drive(), CAR, ("rear_cornering_stiffness",))
    assert found["yaw_rate_noise"] == pytest.approx(0.004 * factor, rel=1e-3)
    assert found["bank_wander_time"] == pytest.approx(6.0, rel=1e-3)
