import dataclasses
import math

import numpy as np
import pytest

from monitors.friction.study_drives import signals
from tierod.core.block import rebuild
from tierod.core.graph import scan
from tierod.monitors.friction.estimator import PreslidingFrictionFilter
from tierod.monitors.friction.signals import SteeringSample
from tierod.physics.steering import weight_lever
from tierod.vehicles import load
from tierod_lab.ground import EpsCar, run
from tierod_lab.ground.chassis.laws import parking_torque
from tierod_lab.ground.courses.roads import NaturalDrive

VEHICLE = load("midsize-eps")
FILTER = PreslidingFrictionFilter.of_vehicle(VEHICLE)
SEED = 1001


def settled(samples, block=FILTER, rate=100.0):
    result = scan(block, samples)
    estimates = result["friction_torque"][np.cumsum(result["enabled"]) / rate > 50.0]
    assert len(estimates) > 60.0 * rate
    return estimates


@pytest.mark.parametrize(
    ("degrees", "level", "error"),
    [(3.0, 12.5, 0.1), (0.01, 4.0, 0.15), pytest.param(0.3, 12.5, 0.1, marks=pytest.mark.slow)],
)
def test_dahl_and_coulomb_friction_of_unknown_angle(degrees, level, error):
    estimates = settled(signals(SEED, level, dahl=degrees))
    assert abs(estimates.mean() - level) <= error
    assert estimates.std() <= 0.1


def test_learns_what_weight_turn_slip_and_drive_force_do():
    """The virtual car's lever is 14 mm, its patches have 0.068 m**2 by Gough and twist, and it is driven in front."""
    result = scan(FILTER, signals(SEED))
    chassis = EpsCar().chassis
    pins = chassis.kingpins
    lever = weight_lever(pins.scrub_radius, pins.inclination, chassis.front.tyre.radius)
    tyre, wheel_load = chassis.front.tyre, 0.5 * chassis.front_load
    scrub = parking_torque(wheel_load, tyre.friction, tyre.pressure)
    stiffness = scrub / tyre.twist_angle * tyre.twist_length / wheel_load
    assert result["weight_lever"][-1] == pytest.approx(lever, rel=0.3)
    assert result["turn_slip"][-1] == pytest.approx(stiffness, rel=0.3)
    assert 0.8 < result["drive_share"][-1] < 1.4


def test_nothing_is_learnt_while_the_gate_is_closed():
    samples = signals(SEED)[:20000].copy()
    learning = scan(FILTER, samples)
    samples[:, 6] = 2.0
    before = scan(FILTER, samples[:50], learning.state)
    after = scan(FILTER, samples[50:], before.state)
    assert learning["enabled"].any()
    assert not after["enabled"].any()
    learnt = [rebuild(FILTER.init(), memory.values.tolist()) for memory in (before.state, after.state)]
    assert learnt[0].mean == learnt[1].mean
    assert learnt[0].covariance == learnt[1].covariance


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
def test_missing_samples_do_no_harm(bad):
    samples = signals(SEED, 8.0).copy()
    generator = np.random.default_rng(5)
    samples[generator.random(samples.shape) < 0.02] = bad
    samples[20000:23000] = bad
    samples[30000:33000, 2] = bad
    result = scan(FILTER, samples)
    assert np.isfinite(result.values).all()
    assert result["friction_torque"][-1] == pytest.approx(8.0, abs=0.15)
    assert not result["enabled"][20000:23100].any()
    assert result["enabled"][23300:30000].any()


def test_friction_of_a_loaded_gear_is_read_at_the_load_it_is_stated_for():
    """Two fifths of 4 N*m grow with the load of the gear, whose level is given for 8 N*m: 3.2 at 4 N*m."""
    steering = dataclasses.replace(EpsCar().steering, reference_load=8.0)
    steering = dataclasses.replace(steering, friction=dataclasses.replace(steering.friction, load_share=0.4))
    car = dataclasses.replace(EpsCar(), steering=steering)
    drive = run(car, NaturalDrive(name="loaded", seed=SEED, time=240.0), seed=SEED).recording
    samples = drive.align(SteeringSample._fields, 100.0).values
    result = scan(FILTER, samples)
    assert result["friction_torque"][-1] == pytest.approx(3.2, abs=0.3)
    assert result["load_share"][-1] == pytest.approx(0.4 * 4.0 / 8.0, abs=0.12)
