import numpy as np
import pytest

from monitors.motor_angle.motor_drives import drive, observed
from monitors.motor_angle.steady_motor import steady
from tierod.core.graph import scan
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.flux_observer import FluxObserver

P = load("motor-bench").parameters_for(SampledMotorParameters)


@pytest.mark.parametrize("speed", [-100.0, 15.0, 100.0])
def test_at_a_steady_speed_it_is_right_whatever_the_load(speed):
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


def test_it_turns_on_while_samples_are_missing():
    samples = steady(60.0, 12.0)
    samples[3000:3200, 2] = np.nan
    found = scan(FluxObserver(P), samples)
    np.testing.assert_allclose(found["motor_angle"][3000:], samples[3000:, 4], atol=2e-3)


def test_it_follows_a_drive_with_reversals():
    signals = drive(20)
    error = observed(FluxObserver(P), signals)["motor_angle"] - signals["truth_angle"]
    electrical = (4.0 * error + np.pi) % (2.0 * np.pi) - np.pi
    fast = np.abs(signals["truth_speed"]) > 80.0
    assert np.sqrt(np.mean(electrical[fast] ** 2)) < 0.03
