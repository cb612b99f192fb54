import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.rigs import SENSORS, Car
from tierod_lab.ground.faults import (
    AtTime,
    BitFlip,
    Course,
    Delay,
    Drift,
    DropOut,
    Fault,
    Gain,
    Intermittent,
    Noise,
    Offset,
    Outlier,
    Ramp,
    Scale,
    Schedule,
    Sluggish,
    Step,
    Stuck,
    TorqueLoss,
    TotalLoss,
    WithTemperature,
)
from tierod_lab.ground.sensors import Sensor, SensorSet

SECONDS = 20.0
TIME = np.arange(2000) / 100.0
TRUTH = 0.2 * np.sin(TIME)
START, END = 5.0, 8.0
INSIDE = (TIME >= START) & (TIME < END)
SINCE = TIME - START


def schedule(behaviour, element="sensor.yaw_rate", seed=0, sensors=SENSORS, duration=END - START):
    return Schedule([Fault(element, behaviour, AtTime(START), duration)], Car(), sensors, seed, SECONDS)


def faulty(behaviour, seed=0, sensors=SENSORS, values=TRUTH):
    time, faulty = schedule(behaviour, seed=seed, sensors=sensors).on_channel("yaw_rate", TIME, values)
    assert np.array_equal(time, TIME)
    assert np.array_equal(faulty[~INSIDE], values[~INSIDE]), "a fault-free signal stays what it is, to the bit"
    return faulty


@pytest.mark.parametrize(
    ("behaviour", "expected"),
    [
        (TotalLoss(), 0.0 * TRUTH),
        (Stuck(), np.full(2000, 0.2 * math.sin(4.99))),
        (Stuck(0.7), np.full(2000, 0.7)),
        (Offset(0.3), TRUTH + 0.3),
        (Offset("-10 deg/s"), TRUTH - math.radians(10.0)),
        (Gain(-1.5), -1.5 * TRUTH),
        (Drift(0.1), TRUTH + 0.1 * SINCE),
        (Drift(-0.1, limit=0.2), TRUTH - np.minimum(0.1 * SINCE, 0.2)),
        (Outlier(4.0), 4.0 * TRUTH),
        (Outlier(value=1.5), np.full(2000, 1.5)),
        (Delay(0.25), 0.2 * np.sin(TIME - 0.25)),
    ],
)
def test_a_signal_behaves_as_defined(behaviour, expected):
    np.testing.assert_allclose(faulty(behaviour)[INSIDE], expected[INSIDE], rtol=0.0, atol=1e-12)


def test_noise_has_its_deviation_and_is_white():
    added = np.concatenate([(faulty(Noise(0.05), seed) - TRUTH)[INSIDE] for seed in range(20)])
    assert np.std(added) == pytest.approx(0.05, rel=0.03)
    assert abs(np.corrcoef(added[1:], added[:-1])[0, 1]) < 0.04


@given(st.integers(-30_000, 30_000), st.integers(0, 15))
def test_a_bit_flip_turns_one_bit_over(raw, bit):
    sensors = SensorSet({"yaw_rate": Sensor(quantum=0.25)})
    values = np.full(2000, 0.25 * raw)
    changed = faulty(BitFlip(bit), sensors=sensors, values=values)[INSIDE]
    assert (changed == changed[0]).all()
    assert (int(changed[0] / 0.25) ^ raw) & 0xFFFF == 1 << bit
    assert -(2**15) <= changed[0] / 0.25 < 2**15
    again = faulty(BitFlip(bit), sensors=sensors, values=np.where(INSIDE, changed[0], values))[INSIDE]
    assert again[0] == values[0]


def test_dropped_frames_are_absent_or_repeated():
    time, values = schedule(DropOut()).on_channel("yaw_rate", TIME, TRUTH)
    assert np.array_equal(time, TIME[~INSIDE])
    assert np.array_equal(values, TRUTH[~INSIDE])
    share = [2000 - len(schedule(DropOut(0.3), seed=seed).on_channel("yaw_rate", TIME, TRUTH)[0]) for seed in range(20)]
    assert np.mean(share) == pytest.approx(0.3 * 300, rel=0.05)
    repeated = faulty(DropOut(0.3, repeat=True))
    lost = schedule(DropOut(0.3)).on_channel("yaw_rate", TIME, TRUTH)[0]
    same = np.flatnonzero(np.diff(repeated) == 0.0) + 1
    assert np.array_equal(np.setdiff1d(np.arange(2000), np.searchsorted(TIME, lost)), same)


def test_an_intermittent_fault_is_there_for_its_share_of_time_and_begins_so():
    shares = []
    for seed in range(60):
        there = faulty(Intermittent(Offset(1.0), mean_on=0.1, mean_off=0.2), seed)[INSIDE] - TRUTH[INSIDE] > 0.5
        assert there[0]
        shares.append(there.mean())
    assert np.mean(shares) == pytest.approx(1.0 / 3.0, abs=0.05)


def parameter(behaviour, element="steering.level"):
    return schedule(behaviour, element).inputs(TIME).get(f"parameters.{element}")


@pytest.mark.parametrize(
    ("behaviour", "expected"),
    [
        (Step(8.0), np.full(2000, 8.0)),
        (Ramp(8.0, over=2.0), 4.0 + 2.0 * np.minimum(SINCE, 2.0)),
        (Scale(2.5), np.full(2000, 10.0)),
        (Scale(0.5, over=2.0), 4.0 - np.minimum(SINCE, 2.0)),
        (Course((1.0, 2.0), (5.0, "7 N*m")), np.clip(5.0 + 2.0 * (SINCE - 1.0), 5.0, 7.0)),
        (Drift(0.1), 4.0 + 0.1 * SINCE),
        (WithTemperature(353.15, time_constant=2.0), 4.0 * (1.0 + 0.00393 * 60.0 * (1.0 - np.exp(-SINCE / 2.0)))),
    ],
)
def test_a_parameter_changes_as_defined(behaviour, expected):
    values = parameter(behaviour)
    np.testing.assert_allclose(values[INSIDE], expected[INSIDE], rtol=1e-12)
    assert (values[~INSIDE] == 4.0).all()


def test_a_sluggish_actuator_is_one_with_another_lag():
    slow = schedule(Sluggish(0.08), "motor_torque")
    assert slow.parameters == ("steering.motor.lag",)
    assert set(slow.inputs(TIME)["parameters.steering.motor.lag"]) == {0.002, 0.08}


def test_a_torque_loss_leaves_the_rest():
    given = schedule(TorqueLoss(0.6), "motor_torque").inputs(TIME)
    assert set(given) == {f"ports.motor_torque.{part}" for part in ("gain", "offset", "held")}
    np.testing.assert_allclose(given["ports.motor_torque.gain"], np.where(INSIDE, 0.4, 1.0))
