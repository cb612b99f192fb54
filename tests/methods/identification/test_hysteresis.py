from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from driven import lock_to_lock as virtual_turn
from methods.identification.lock_to_lock import DAMPING, GEAR, INERTIA, lock_to_lock
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.hysteresis import HysteresisIdentification, friction_increase
from tierod.methods.identification.lock_to_lock import Loop, Motion, work_balance
from tierod.vehicles import load

IDENTIFICATION = HysteresisIdentification(GEAR, INERTIA, DAMPING, damping_deviation=0.2)
HEALTHY = 4.0


def changed(recording: Recording, name: str, values=None, time=None) -> Recording:
    channel = recording[name]
    new = Channel(
        name,
        channel.time if time is None else time,
        channel.values if values is None else values,
        channel.unit,
    )
    return Recording({**recording.channels, name: new})


@pytest.mark.parametrize("support", ["hoist", "ground"])
@pytest.mark.parametrize("added", [0.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (1.5, 4.0)), 8.5])
def test_added_friction_within_three_tenths(added, support):
    unfaulted = [IDENTIFICATION.identify(lock_to_lock(HEALTHY, support, seed=s), support) for s in (1, 2)]
    faulted = IDENTIFICATION.identify(lock_to_lock(HEALTHY + added, support, seed=3), support)
    increase = friction_increase(faulted, unfaulted)
    assert increase.value == pytest.approx(added, abs=0.3)
    assert abs(increase.value - added) < 4.0 * increase.standard_deviation + 0.05
    if support == "hoist":
        assert faulted.friction_torque == pytest.approx(HEALTHY + added, abs=0.3)


@pytest.mark.parametrize("support", ["hoist", "ground"])
@pytest.mark.parametrize("added", [0.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (1.5, 4.0)), 8.5])
def test_added_friction_of_the_virtual_car_within_three_tenths(added, support):
    hoist, method = support == "hoist", HysteresisIdentification.of_vehicle(load("midsize-eps"))
    unfaulted = method.identify(virtual_turn(HEALTHY, hoist, seed=1), support)
    faulted = method.identify(virtual_turn(HEALTHY + added, hoist, seed=2), support)
    assert friction_increase(faulted, unfaulted).value == pytest.approx(added, abs=0.3)
    if support == "hoist":
        assert faulted.friction_torque == pytest.approx(HEALTHY + added, abs=0.1)
        assert faulted.pre_sliding is not None
        assert math.degrees(faulted.pre_sliding.angle) == pytest.approx(1.0, abs=0.2)


def test_a_test_without_assist_is_judged():
    test = lock_to_lock(HEALTHY, noise=0.0)
    driver = test["driver_torque"].values + GEAR * test["motor_torque"].values
    unassisted = changed(test, "motor_torque", np.zeros_like(driver))
    found = IDENTIFICATION.identify(changed(unassisted, "driver_torque", driver), "hoist")
    assert found.friction_torque == pytest.approx(IDENTIFICATION.identify(test, "hoist").friction_torque)


def test_the_twist_of_an_elastic_bar_is_no_pre_sliding():
    stiff, rigid = lock_to_lock(12.5, noise=0.0), IDENTIFICATION
    twist = stiff["driver_torque"].values / 40.0
    soft = changed(stiff, "steering_wheel_angle", stiff["steering_wheel_angle"].values + twist)
    soft = changed(soft, "steering_wheel_rate", np.gradient(soft["steering_wheel_angle"].values, 0.01))
    elastic = dataclasses.replace(rigid, torsion_bar_stiffness=40.0)
    assert math.degrees(elastic.identify(soft, "hoist").pre_sliding.angle) == pytest.approx(1.0, abs=0.1)
    assert elastic.identify(soft, "hoist").friction_torque == pytest.approx(12.5, abs=0.05)
    seen = rigid.identify(soft, "hoist").pre_sliding
    assert seen is None or math.degrees(seen.angle) > 3.0


def test_the_steering_wheel_is_above_the_bar():
    method = HysteresisIdentification.of_vehicle(load("midsize-eps"))
    assert method.inertia == pytest.approx(0.065)
    assert method.damping == pytest.approx(0.6)
    assert method.torsion_bar_stiffness == 140.0
    counts = HysteresisIdentification.of_vehicle(load("rav4"))
    assert math.isinf(counts.torsion_bar_stiffness)


def test_the_work_balance_closes_term_by_term():
    found = IDENTIFICATION.identify(lock_to_lock(HEALTHY, noise=0.0, loops=2), "hoist")
    assert len(found.loops) == 2
    for one in found.loops:
        balance = one.driver_work + one.motor_work - one.kinetic_energy - one.viscous_work
        assert balance == pytest.approx(one.friction_torque * one.path, rel=1e-9)
        assert one.path == pytest.approx(4.0 * math.radians(570.0), rel=1e-2)
        assert one.friction_torque == pytest.approx(HEALTHY, abs=0.05)


def test_damping_that_is_not_taken_off_shows_as_friction():
    undamped = dataclasses.replace(IDENTIFICATION, damping=0.0)
    recording = lock_to_lock(HEALTHY, noise=0.0)
    with_damping, without = (one.identify(recording, "hoist") for one in (IDENTIFICATION, undamped))
    viscous = DAMPING * with_damping.mean_rate
    assert without.friction_torque - with_damping.friction_torque == pytest.approx(viscous, rel=1e-6)
    assert viscous > 0.8


def test_a_torque_offset_shows_in_the_directions_not_in_the_friction():
    found = IDENTIFICATION.identify(lock_to_lock(HEALTHY, torque_offset=0.5), "hoist")
    (one,) = found.loops
    assert one.friction_torque == pytest.approx(HEALTHY, abs=0.1)
    assert one.friction_towards_left - one.friction_towards_right == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("degrees", [0.5, 1.0, 3.0])
def test_pre_sliding_angle_from_the_reversals(degrees):
    found = IDENTIFICATION.identify(lock_to_lock(HEALTHY, pre_sliding=math.radians(degrees)), "hoist")
    assert found.pre_sliding is not None
    assert math.degrees(found.pre_sliding.angle) == pytest.approx(degrees, rel=0.25)


def test_coulomb_friction_shows_no_pre_sliding_angle():
    found = IDENTIFICATION.identify(lock_to_lock(HEALTHY, pre_sliding=math.radians(0.01), noise=0.1), "hoist")
    assert found.pre_sliding is None or found.pre_sliding.angle < math.radians(0.3)


def test_the_profile_shows_a_tight_spot():
    recording = lock_to_lock(HEALTHY, noise=0.0)
    angle = recording["steering_wheel_angle"].values
    rate = recording["steering_wheel_rate"].values
    tight = np.where(np.abs(angle - 3.0) < 1.0, 2.0, 0.0) * np.sign(rate)
    recording = changed(recording, "driver_torque", recording["driver_torque"].values + tight)
    found = IDENTIFICATION.identify(recording, "hoist")
    at = np.interp([-3.0, 3.0], found.profile_angle, found.profile_friction)
    assert at == pytest.approx([HEALTHY, HEALTHY + 2.0], abs=0.15)


def test_the_rate_is_derived_where_it_is_not_recorded():
    channels = dict(lock_to_lock(HEALTHY).channels)
    del channels["steering_wheel_rate"], channels["vehicle_speed"]
    assert IDENTIFICATION.identify(Recording(channels), "hoist").friction_torque == pytest.approx(HEALTHY, abs=0.1)


def test_a_loop_from_lock_to_lock_and_back():
    whole = lock_to_lock(HEALTHY, loops=2)
    time, angle = whole["steering_wheel_angle"].time, whole["steering_wheel_angle"].values
    first, last = time[np.argmin(angle)], time[len(angle) // 2 + np.argmin(angle[len(angle) // 2 :])]
    cut = {}
    for name, channel in whole.channels.items():
        inside = (channel.time >= first) & (channel.time <= last)
        cut[name] = Channel(name, channel.time[inside], channel.values[inside], channel.unit)
    assert IDENTIFICATION.identify(Recording(cut), "hoist").friction_torque == pytest.approx(HEALTHY, abs=0.2)


def test_damping_enters_the_uncertainty_but_hardly_that_of_a_difference():
    slow, quick = (IDENTIFICATION.identify(lock_to_lock(HEALTHY, seconds_per_turn=s), "hoist") for s in (5.0, 2.0))
    assert slow.standard_deviation == pytest.approx(0.2 * slow.mean_rate, rel=0.1)
    again = IDENTIFICATION.identify(lock_to_lock(HEALTHY + 4.0, seed=7), "hoist")
    assert friction_increase(again, slow).standard_deviation < 0.05
    assert friction_increase(again, quick).standard_deviation > 0.2


REFUSED = {
    "deg, but a lock-to-lock loop needs": lambda: lock_to_lock(HEALTHY, lock=math.radians(200.0)),
    "does not close": lambda: _cut(lock_to_lock(HEALTHY), 0.75),
    "in more than 3 s from lock to lock": lambda: lock_to_lock(HEALTHY, seconds_per_turn=1.0),
    "the vehicle moves at up to 5.0 m/s": lambda: _moving(lock_to_lock(HEALTHY)),
    "turn the sign": lambda: _mirrored(lock_to_lock(HEALTHY)),
    "driver_torque is missing or stuck for 1.0 s within the test": lambda: _holed(lock_to_lock(HEALTHY)),
    "is sampled every 1 s": lambda: _sparse(lock_to_lock(HEALTHY)),
    "holds no values": lambda: changed(
        lock_to_lock(HEALTHY), "steering_wheel_angle", np.full(len(lock_to_lock(HEALTHY)["driver_torque"].time), np.nan)
    ),
    "no channel 'motor_torque'": lambda: Recording(
        {n: c for n, c in lock_to_lock(HEALTHY).channels.items() if n != "motor_torque"}
    ),
}


def _cut(recording, share):
    cut = {}
    for name, channel in recording.channels.items():
        count = int(share * len(channel.time))
        cut[name] = Channel(name, channel.time[:count], channel.values[:count], channel.unit)
    return Recording(cut)


def _moving(recording):
    return changed(recording, "vehicle_speed", np.full_like(recording["vehicle_speed"].values, 5.0))


def _mirrored(recording):
    for name in ("steering_wheel_angle", "steering_wheel_rate"):
        recording = changed(recording, name, -recording[name].values)
    return recording


def _holed(recording):
    values = recording["driver_torque"].values.copy()
    values[1000:1100] = np.nan
    return changed(recording, "driver_torque", values)


def _sparse(recording):
    channel = recording["steering_wheel_angle"]
    return Recording(
        {**recording.channels, channel.name: Channel(channel.name, channel.time[::100], channel.values[::100], "rad")}
    )


@pytest.mark.parametrize("sentence", REFUSED)
def test_a_recording_that_is_no_lock_to_lock_test_is_refused(sentence):
    with pytest.raises(InputError) as caught:
        IDENTIFICATION.identify(REFUSED[sentence](), "hoist")
    assert sentence in str(caught.value)


def test_an_unknown_support_and_mixed_supports_are_refused():
    with pytest.raises(ParameterError, match="'hoist' or 'ground'"):
        IDENTIFICATION.identify(lock_to_lock(HEALTHY), "lift")
    hoist = IDENTIFICATION.identify(lock_to_lock(HEALTHY), "hoist")
    ground = IDENTIFICATION.identify(lock_to_lock(HEALTHY, "ground"), "ground")
    with pytest.raises(ParameterError, match="one support only"):
        friction_increase(ground, hoist)
    with pytest.raises(ParameterError, match="none"):
        friction_increase(ground, [])


def test_kinetic_energy_left_at_the_end_of_a_loop_is_no_friction():
    inertia, friction, stroke = 0.4, 3.0, 2.0
    out = np.linspace(0.0, stroke, 401)
    angle = np.concatenate([out, out[-2::-1]])
    squared = 1.0 + 1.5 * np.linspace(0.0, 2.0 * stroke, len(angle))  # w^2 grows by 1.5 per rad of the path
    way = np.where(np.arange(len(angle)) <= 400, 1.0, -1.0)
    torque = way * (friction + 0.5 * inertia * 1.5)  # J dw/dt = J d(w^2)/dx / 2
    torque[400] = torque[399]
    motion = Motion(np.arange(len(angle)) * 0.01, angle, angle, way * np.sqrt(squared), torque, 0.0 * angle)
    loop = Loop(0, len(angle) - 1, (400,), 0.0)
    found = work_balance(loop, motion, inertia, 0.0)
    assert found.kinetic_energy == pytest.approx(0.5 * inertia * (squared[-1] - squared[0]))
    assert found.friction_torque == pytest.approx(friction, rel=5e-3)
