"""The lock-to-lock test from recording to finding."""

import dataclasses

import numpy as np
import pytest

from driven import lock_to_lock
from exact_vehicle import diagnose
from said import said
from tierod.core.findings import Status
from tierod.monitors import diagnose as running
from tierod.monitors.registry import MONITORS
from tierod.vehicles import Parameter, load


@pytest.mark.parametrize("support", MONITORS["hysteresis"].variants)
@pytest.mark.parametrize(
    ("added", "status"),
    [
        (0.0, Status.HEALTHY),
        (1.5, Status.RISING),
        (4.0, Status.FAULT),
        pytest.param(8.5, Status.FAULT, marks=pytest.mark.slow),
    ],
)
def test_the_increase_over_the_unfaulted_loop_is_found(tmp_path, support, added, status):
    level, hoist = tmp_path / "level.json", support == "hoist"
    diagnose(lock_to_lock(4.0, hoist, seed=1), "midsize-eps", "hysteresis", support, baseline=level)
    test = lock_to_lock(4.0 + added, hoist, seed=2)
    finding = diagnose(test, "midsize-eps", "hysteresis", support, baseline=level).findings[0]
    assert finding.evidence["increase_Nm"] == pytest.approx(added, abs=0.3)
    assert finding.status is status


def test_on_the_hoist_it_is_held_against_nominal():
    finding = diagnose(lock_to_lock(9.0, hoist=True), "midsize-eps", "hysteresis", "hoist").findings[0]
    assert finding.status is Status.FAULT
    assert finding.estimate.reference == {"nominal": 4.0, "rising": pytest.approx(4.8), "fault": pytest.approx(7.5)}
    assert "fault from 7.5 N·m" in said(finding)
    assert finding.warnings == ()
    assert finding.estimate.value == pytest.approx(9.0, abs=0.3)
    assert finding.estimate.standard_deviation > 0.0


def scattered(recording, name="steering_wheel_angle", noise=0.0, jitter=0.0, seed=7):
    """A recording whose signal has white noise, and time stamps that scatter [s]."""
    random, channel = np.random.default_rng(seed), recording[name]
    values = channel.values + noise * random.normal(size=len(channel.values))
    time = channel.time + jitter * random.normal(size=len(channel.time))
    order = np.argsort(time, kind="stable")
    return recording.with_channels([dataclasses.replace(channel, time=time[order], values=values[order])])


def on_hoist(recording):
    return diagnose(recording, "midsize-eps", "hysteresis", "hoist", spread=False).findings[0]


@pytest.mark.parametrize("disturbed", [{"noise": 0.02}, {"noise": 0.05}, {"jitter": 0.05}])
@pytest.mark.parametrize(("friction", "status"), [(4.0, Status.HEALTHY), (8.5, Status.FAULT)])
def test_noise_and_jitter_of_the_angle_hide_no_worn_rack(disturbed, friction, status):
    finding = on_hoist(scattered(lock_to_lock(friction, hoist=True, seed=31), **disturbed))
    assert finding.status is status
    assert finding.estimate.value == pytest.approx(friction, abs=0.15)
    measured = finding.evidence["steering_wheel_angle_noise_rad"]
    assert measured == pytest.approx(disturbed.get("noise", 0.045), rel=0.2)
    (warning,) = [each for each in finding.warnings if "steering_wheel_angle" in each]
    assert ("as of time stamps" in warning) == ("jitter" in disturbed)


def torques(recording, driver=1.0, motor=1.0):
    factors = {"driver_torque": driver, "motor_torque": motor}
    return recording.with_channels(
        [
            dataclasses.replace(recording[name], values=factor * recording[name].values)
            for name, factor in factors.items()
        ]
    )


@pytest.mark.parametrize("support", MONITORS["hysteresis"].variants)
@pytest.mark.parametrize("factors", [{"driver": 2.0}, {"driver": 0.5}, {"motor": 2.0}, {"motor": 0.5}])
def test_a_gain_of_one_torque_is_named_and_learnt_by_no_baseline(tmp_path, support, factors):
    level, hoist = tmp_path / "level.json", support == "hoist"
    test = torques(lock_to_lock(4.0, hoist, seed=1), **factors)
    finding = diagnose(test, "midsize-eps", "hysteresis", support, baseline=level).findings[0]
    assert any("driver_torque or motor_torque has a wrong gain" in each for each in (finding.cause, *finding.warnings))
    assert finding.status is (Status.SUSPECT if hoist else Status.NOT_TESTABLE)
    assert not level.exists()


GAIN = "torque_gain_deviation"


def spread_of(**deviations):
    """The shipped car with other standard deviations, and with a gain deviation where one is given."""
    car = load("midsize-eps")
    parameters = dict(car.parameters)
    if (gain := deviations.pop(GAIN, None)) is not None:
        parameters[GAIN] = Parameter(GAIN, gain, "", None, "calibration")
    for name, deviation in deviations.items():
        parameters[name] = dataclasses.replace(parameters[name], standard_deviation=deviation)
    return dataclasses.replace(car, parameters=parameters)


def uncertain(recording, car="midsize-eps", **given):
    return running.diagnose(recording, car, "hysteresis", "hoist", **given)


@pytest.mark.parametrize("spread", [True, False])
@pytest.mark.parametrize(
    ("deviations", "names"),
    [
        ({"column_damping": 4.0}, ["column_damping"]),
        ({GAIN: 0.6}, [GAIN]),
        ({"column_damping": 1.6, GAIN: 0.4}, ["column_damping", GAIN]),  # each alone would not reach the fault
    ],
)
def test_what_may_hide_a_fault_leaves_no_verdict_and_is_named(deviations, names, spread):
    finding = uncertain(lock_to_lock(4.0, hoist=True, seed=1), spread_of(**deviations), spread=spread).findings[0]
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert "healthy" not in finding.headline
    assert all(name in finding.cause for name in names)
    # The file states the gain's deviation already: to enter it is no advice.
    assert ("measure column_damping first" in finding.action) == ("column_damping" in names)
    assert "enter torque_gain_deviation" not in finding.action
    assert finding.action.startswith("give a fault-free drive of this car as baseline: 'tierod diagnose")
    assert finding.estimate.value + 1.96 * finding.estimate.standard_deviation > 7.5


def test_the_users_word_makes_a_baseline_of_a_car_that_only_a_guessed_nominal_friction_suspects(tmp_path):
    level, own = tmp_path / "car.json", lock_to_lock(5.0, hoist=True, seed=1)
    doubted = uncertain(own, baseline=level)
    assert doubted.findings[0].status is Status.SUSPECT
    assert not level.exists()
    assert "--fault-free" in doubted.findings[0].action
    assert "add --fault-free" in doubted.remarks["baseline"]
    uncertain(own, baseline=level, fault_free=True)
    assert level.exists()
    for friction, status in ((5.0, Status.HEALTHY), (9.5, Status.FAULT)):
        again = uncertain(lock_to_lock(friction, hoist=True, seed=2), baseline=level).findings[0]
        assert again.status is status
        assert "±" in again.details[0].split("against")[0]  # the increase has its own deviation
