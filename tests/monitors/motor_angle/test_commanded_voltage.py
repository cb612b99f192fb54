"""The observer that knows the inverter's command alone, behind an inverter with 1 us of dead time and 0.7 V of drop."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.models.stator_frame_motor import CommandedMotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod.vehicles import load
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import SAMPLE_TIME, to_and_fro

VEHICLE = load("motor-bench")
OBSERVER = MotorAngleObserver.of_vehicle(VEHICLE, SAMPLE_TIME, commanded=True)
LOSSY = Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=1.0)
DRIVES = [to_and_fro(seed, 10.0, inverter=LOSSY) for seed in (80, 81)]


def with_parameters(**values):
    return replace(OBSERVER, parameters=replace(OBSERVER.parameters, **values))


def error(found, drive):
    return found["motor_angle"] - drive.angle


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("knee", [0.5, 1.0, 2.0])
def test_it_follows_the_angle_with_a_knee_within_a_factor_of_two(knee):
    for drive in DRIVES:
        found = scan(with_parameters(inverter_knee_current=knee), drive.commanded)
        assert rms(error(found, drive)) < 0.01


def test_it_learns_what_the_inverter_takes():
    found = scan(with_parameters(inverter_knee_current=2.0), DRIVES[0].commanded)
    assert found["inverter_voltage_loss"][-1] == pytest.approx(0.13 + 0.7, abs=0.06)
    assert found["inverter_knee_current"][-1] == pytest.approx(1.0, rel=0.1)
    assert found["inverter_knee_deviation"][-1] < 0.05


def test_a_command_taken_for_a_measured_voltage_loses_the_angle():
    blind = MotorAngleObserver(VEHICLE.parameters_for(SampledMotorParameters))
    assert max(rms(error(scan(blind, drive.commanded), drive)) for drive in DRIVES) > 0.1


def test_a_knee_that_is_held_wrong_costs_the_angle():
    held = replace(with_parameters(inverter_knee_current=0.5), tuning=MotorAngleTuning(first_knee=0.0))
    found = scan(held, DRIVES[0].commanded)
    assert rms(error(found, DRIVES[0])) > 0.01
    assert np.ptp(found["inverter_knee_current"]) == pytest.approx(0.0, abs=1e-12)


def test_with_measured_voltages_nothing_is_said_to_be_lost():
    found = scan(MotorAngleObserver.of_vehicle(VEHICLE, SAMPLE_TIME), DRIVES[0].samples[:100])
    assert not found["inverter_voltage_loss"].any()
    assert not OBSERVER.of_vehicle(VEHICLE, SAMPLE_TIME).commanded
    assert isinstance(OBSERVER.parameters, CommandedMotorParameters)
