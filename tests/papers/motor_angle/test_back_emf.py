import math

import numpy as np
import pytest

from monitors.motor_angle.motor_drives import drive, observed
from monitors.motor_angle.steady_motor import FLUX, INDUCTANCE, load_torque, steady
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.back_emf import FeedforwardAngle, FeedforwardWithLoad, FluxObserver

P = load("motor-bench").parameters_for(SampledMotorParameters)


@pytest.mark.parametrize("speed", [-150.0, -20.0, 20.0, 150.0])
@pytest.mark.parametrize("current", [(0.0, 12.0), (-8.0, -15.0)])
def test_at_a_steady_speed_angle_and_speed_are_exact_the_lag_of_the_filter_taken_back(speed, current):
    samples = steady(speed, current[1], current_d=current[0])
    found = scan(FeedforwardAngle(P), samples)
    assert found["motor_angle"][-1] == pytest.approx(samples[-1, 4], abs=2e-4)
    assert found["motor_speed"][-1] == pytest.approx(speed, rel=2e-3)


@pytest.mark.parametrize("current", [4.0, 12.0, -12.0])
def test_with_the_printed_sign_the_angle_is_turned_by_the_inductance(current):
    samples = steady(30.0, current)
    found = scan(FeedforwardAngle(P, reading="printed"), samples)
    error = 4.0 * (samples[-1, 4] - found["motor_angle"][-1])
    assert abs(error) == pytest.approx(math.atan(2.0 * INDUCTANCE * abs(current) / FLUX), abs=5e-3)
    assert abs(error) == pytest.approx({4.0: 0.094, 12.0: 0.275}[abs(current)], abs=5e-3)


def test_a_slow_motor_shows_nothing_and_its_angle_is_held_or_follows_increments():
    samples = steady(2.0, 5.0, seconds=0.3)
    held = scan(FeedforwardAngle(P), samples)
    assert held["standing"].all()
    assert (held["motor_angle"] == held["motor_angle"][0]).all()
    followed = scan(FeedforwardAngle(P, slow="increments"), samples)
    np.testing.assert_allclose(followed["motor_angle"], samples[:, 4], atol=1e-9)


@pytest.mark.parametrize("slow", ["held", "increments"])
def test_it_keeps_the_angle_over_reversals(slow):
    signals = drive(20)
    error = observed(FeedforwardAngle(P, slow=slow), signals)["motor_angle"] - signals["truth_angle"]
    fast = np.abs(signals["truth_speed"]) > 20.0
    assert np.sqrt(np.mean((4.0 * error[fast]) ** 2)) < 0.04
    assert np.abs(error).max() < 0.5


@pytest.mark.parametrize(("make", "column"), [(FeedforwardAngle, 0), (FluxObserver, 2)])
def test_it_turns_on_while_samples_are_missing(make, column):
    samples = steady(60.0, 12.0)
    samples[3000:3200, column] = np.nan
    found = scan(make(P), samples)
    np.testing.assert_allclose(found["motor_angle"][3000:], samples[3000:, 4], atol=2e-3)


def test_with_the_rotor_it_knows_the_load_too():
    samples = steady(60.0, 12.0)
    found = scan(FeedforwardWithLoad.of(P), samples)
    assert found["motor_angle"][-1] == pytest.approx(samples[-1, 4], abs=1e-3)
    assert found["motor_speed"][-1] == pytest.approx(60.0, rel=1e-3)
    assert found["motor_load_torque"][-1] == pytest.approx(load_torque(60.0, 12.0), rel=0.01)


def test_with_the_rotor_the_noise_is_less():
    signals = drive(20)
    fast = np.abs(signals["truth_speed"]) > 20.0

    def rms(observer):
        return np.sqrt(np.mean((observed(observer, signals)["motor_angle"] - signals["truth_angle"])[fast] ** 2))

    assert rms(FeedforwardWithLoad.of(P, slow="increments")) < 0.6 * rms(FeedforwardAngle(P, slow="increments"))


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="expected held or increments"):
        FeedforwardAngle(P, slow="hold")
    with pytest.raises(ParameterError, match="expected corrected or printed"):
        FeedforwardAngle(P, reading="print")


@pytest.mark.parametrize("speed", [-100.0, 15.0, 100.0])
def test_at_a_steady_speed_the_flux_observer_is_right_whatever_the_load(speed):
    samples = steady(speed, 20.0, current_d=-5.0)
    found = scan(FluxObserver(P), samples)
    assert found["motor_angle"][-1] == pytest.approx(samples[-1, 4], abs=1e-3)
    assert found["motor_speed"][-1] == pytest.approx(speed, rel=1e-3)


def test_a_wrong_beginning_is_forgotten():
    samples = steady(30.0, 5.0, seconds=0.3)
    true = samples[:, 4].copy()
    samples[0, 4] += 0.1
    error = scan(FluxObserver(P), samples)["motor_angle"] - true
    assert error[0] == pytest.approx(0.1)
    assert abs(error[-1]) < 1e-3


def test_the_flux_observer_follows_a_drive_with_reversals():
    signals = drive(20)
    error = observed(FluxObserver(P), signals)["motor_angle"] - signals["truth_angle"]
    electrical = (4.0 * error + np.pi) % (2.0 * np.pi) - np.pi
    fast = np.abs(signals["truth_speed"]) > 80.0
    assert np.sqrt(np.mean(electrical[fast] ** 2)) < 0.03
