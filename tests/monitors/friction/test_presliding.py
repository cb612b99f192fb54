import dataclasses
import math

import numpy as np
import pytest

from monitors.friction.study_drives import Case, signals
from tierod.core.block import rebuild
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.friction.definition import FrictionMonitor
from tierod.monitors.friction.estimator import PreslidingFrictionFilter
from tierod.monitors.friction.sentences import NOTES
from tierod.monitors.friction.signals import SteeringConditioning, SteeringSample
from tierod.physics.aligning import weight_lever
from tierod.physics.tyre import parking_torque
from tierod.vehicles import load
from tierod_lab.ground import EpsCar, run
from tierod_lab.ground.courses.natural import NaturalDrive

VEHICLE = load("midsize-eps")
FILTER = PreslidingFrictionFilter.of_vehicle(VEHICLE)
SEED = 1001


def settled(samples, block=FILTER, rate=100.0):
    result = scan(block, samples)
    estimates = result["friction_torque"][np.cumsum(result["enabled"]) / rate > 50.0]
    assert len(estimates) > 60.0 * rate
    return estimates


@pytest.mark.parametrize(
    ("degrees", "level"),
    [
        (3.0, 12.5),
        (1.0, 8.0),
        *(pytest.param(*each, marks=pytest.mark.slow) for each in ((0.3, 4.0), (0.3, 12.5), (3.0, 4.0))),
    ],
)
def test_dahl_friction_of_unknown_angle(degrees, level):
    estimates = settled(signals(Case(SEED, level, dahl_angle=math.radians(degrees))))
    assert abs(estimates.mean() - level) <= 0.1
    assert estimates.std() <= 0.1


@pytest.mark.parametrize(("degrees", "level"), [pytest.param(3.0, 4.0, marks=pytest.mark.slow), (0.3, 12.5)])
def test_a_noisy_rate_costs_little(degrees, level):
    estimates = settled(signals(Case(SEED, level, dahl_angle=math.radians(degrees), rate_noise=0.05)))
    assert abs(estimates.mean() - level) <= 0.2


@pytest.mark.parametrize("level", [4.0, pytest.param(12.5, marks=pytest.mark.slow)])
def test_coulomb_friction(level):
    estimates = settled(signals(Case(SEED, level, dahl_angle=math.radians(0.01))))
    assert abs(estimates.mean() - level) <= 0.15


@pytest.mark.slow
@pytest.mark.parametrize("law", ["Dahl, exponent 0.5", "Dahl, exponent 2"])
def test_another_law_of_build_up_is_learnt(law):
    estimates = settled(signals(Case(SEED, 12.5, law=law)))
    assert abs(estimates.mean() - 12.5) <= 0.02 * 12.5


@pytest.mark.parametrize(
    ("law", "share"), [pytest.param("Stribeck 20 %", 0.06, marks=pytest.mark.slow), ("load-dependent 40 %", 0.06)]
)
def test_laws_outside_the_model_cost_a_few_percent(law, share):
    estimates = settled(signals(Case(SEED, 4.0, law=law)))
    assert abs(estimates.mean() - 4.0) <= share * 4.0


def test_learns_the_dahl_angle():
    result = scan(FILTER, signals(Case(SEED, 12.5, dahl_angle=math.radians(3.0))))
    assert math.degrees(result["dahl_angle"][-1]) == pytest.approx(3.0, rel=0.15)


def test_learns_what_weight_turn_slip_and_drive_force_do():
    """The virtual car's lever is 14 mm, its patches have 0.068 m**2 by Gough and twist, and it is driven in front."""
    result = scan(FILTER, signals(Case(SEED, 4.0)))
    chassis = EpsCar().chassis
    pins = chassis.kingpins
    lever = weight_lever(pins.scrub_radius, pins.inclination, chassis.front.tyre.radius)
    tyre, wheel_load = chassis.front.tyre, 0.5 * chassis.front_load
    scrub = parking_torque(wheel_load, tyre.friction, tyre.pressure)
    stiffness = scrub / tyre.twist_angle * tyre.twist_length / wheel_load
    assert result["weight_lever"][-1] == pytest.approx(lever, rel=0.3)
    assert result["turn_slip"][-1] == pytest.approx(stiffness, rel=0.3)
    assert 0.8 < result["drive_share"][-1] < 1.4


def test_a_bar_taken_as_rigid_reads_high_and_is_reported():
    samples = signals(Case(SEED, 12.5))
    car = dataclasses.replace(
        VEHICLE, parameters={k: v for k, v in VEHICLE.parameters.items() if k != "torsion_bar_stiffness"}
    )
    assert settled(samples, PreslidingFrictionFilter.of_vehicle(car)).mean() > settled(samples).mean() + 0.1
    rigid, elastic = (FrictionMonitor.of_vehicle(each) for each in (car, VEHICLE))
    assert NOTES["rigid_bar"] in rigid.finding(scan(rigid, samples)).warnings
    assert NOTES["rigid_bar"] not in elastic.finding(scan(elastic, samples)).warnings


def test_counts_have_no_bar():
    assert math.isinf(PreslidingFrictionFilter.of_vehicle(load("rav4")).parameters.torsion_bar_stiffness)


def test_a_mirrored_drive_gives_the_same_friction():
    samples = signals(Case(SEED))
    mirrored = samples * np.array([-1.0] * 6 + [1.0])
    found, expected = (scan(FILTER, each)["friction_torque"] for each in (mirrored, samples))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9, equal_nan=False)


def test_a_common_torque_gain_scales_the_estimate_and_nothing_shows_it():
    samples = signals(Case(SEED, 8.0))
    scaled = samples * np.array([1.0, 1.0, 1.1, 1.1, 1.0, 1.0, 1.0])
    plain, gained = scan(FILTER, samples), scan(FILTER, scaled)
    assert gained["friction_torque"][-1] / plain["friction_torque"][-1] == pytest.approx(1.1, abs=0.01)
    assert gained["misfit"][-1] == pytest.approx(plain["misfit"][-1], abs=0.05)


def test_nothing_is_learnt_while_the_gate_is_closed():
    samples = signals(Case(SEED))[:20000].copy()
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
    samples = signals(Case(SEED, 8.0)).copy()
    generator = np.random.default_rng(5)
    samples[generator.random(samples.shape) < 0.02] = bad
    samples[20000:23000] = bad
    samples[30000:33000, 2] = bad
    result = scan(FILTER, samples)
    assert np.isfinite(result.values).all()
    assert result["friction_torque"][-1] == pytest.approx(8.0, abs=0.15)
    assert not result["enabled"][20000:23100].any()
    assert result["enabled"][23300:30000].any()


def test_one_wild_sample_hardly_moves_the_estimate():
    samples = signals(Case(SEED, 4.0)).copy()
    enabled = scan(FILTER, samples)["enabled"]
    wild = np.flatnonzero(enabled[40000:])[100] + 40000
    samples[wild, 2] = 30.0
    before, after = (scan(FILTER, samples)["friction_torque"][wild + offset] for offset in (-1, 50))
    assert abs(after - before) < 0.15


def test_a_missing_signal_never_enables():
    samples = signals(Case(SEED))[:5000].copy()
    samples[:, 4] = np.nan
    result = scan(FILTER, samples)
    assert np.isfinite(result.values).all()
    assert not result["enabled"].any()
    assert (result["friction_torque"] == FILTER.tuning.initial_friction).all()


def test_other_sample_times_give_the_same_friction():
    estimates = settled(signals(Case(SEED, 8.0))[::2], PreslidingFrictionFilter.of_vehicle(VEHICLE, 0.02), 50.0)
    assert abs(estimates.mean() - 8.0) <= 0.2


def test_the_deviation_widens_where_the_balance_fits_badly():
    samples = signals(Case(SEED, 4.0)).copy()
    time = np.arange(len(samples)) * 0.01
    samples[:, 2] += 3.0 * np.sin(2.0 * math.pi * 0.7 * time)
    disturbed, plain = scan(FILTER, samples), scan(FILTER, signals(Case(SEED, 4.0)))
    assert plain["misfit"][-1] == pytest.approx(1.0, abs=0.1)
    assert disturbed["misfit"][-1] > 3.0
    assert disturbed["friction_deviation"][-1] > 3.0 * plain["friction_deviation"][-1]


def test_two_sample_times_are_refused():
    with pytest.raises(ParameterError, match="same sample_time"):
        dataclasses.replace(FILTER, conditioning=SteeringConditioning(0.02))


def test_friction_is_stated_for_a_load_that_the_car_sees():
    """4 N*m of a mid-size car; a light one with a short front axle load sees less, and its friction is known there."""
    light = dataclasses.replace(VEHICLE.parameters["mass"], value=0.25 * VEHICLE["mass"])
    car = dataclasses.replace(VEHICLE, parameters={**VEHICLE.parameters, "mass": light})
    samples = signals(Case(SEED))[:3000]
    usual = scan(FILTER, samples)["reference_load"][-1]
    assert usual == pytest.approx(4.0, rel=0.01)
    few = scan(PreslidingFrictionFilter.of_vehicle(car), samples)
    assert few["reference_load"][-1] == pytest.approx(0.25 * usual)
    monitor = FrictionMonitor.of_vehicle(VEHICLE)
    evidence = monitor.finding(scan(monitor, signals(Case(SEED)))).evidence
    assert evidence["reference_load_Nm"] == pytest.approx(usual)
    assert abs(evidence["load_share"]) < 0.2


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
