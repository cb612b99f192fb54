import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.faults.car_stand_in import SENSORS, Car
from tierod.core.errors import ParameterError
from tierod_lab.ground.faults import (
    BEHAVIOURS,
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
    Spikes,
    Step,
    Stuck,
    TorqueLoss,
    TotalLoss,
    WithTemperature,
)
from tierod_lab.ground.faults.behaviour import Behaviour
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
        (Stuck("36 deg/s"), np.full(2000, math.radians(36.0))),
        (Offset(0.3), TRUTH + 0.3),
        (Offset(-0.3), TRUTH - 0.3),
        (Offset("-10 deg/s"), TRUTH - math.radians(10.0)),
        (Gain(-1.5), -1.5 * TRUTH),
        (Drift(0.1), TRUTH + 0.1 * SINCE),
        (Drift("6 deg/s/min"), TRUTH + math.radians(0.1) * SINCE),
        (Drift(-0.1, limit=0.2), TRUTH - np.minimum(0.1 * SINCE, 0.2)),
        (Outlier(4.0), 4.0 * TRUTH),
        (Outlier(value=1.5), np.full(2000, 1.5)),
        (Delay(0.25), 0.2 * np.sin(TIME - 0.25)),
    ],
)
def test_a_signal_behaves_as_defined(behaviour, expected):
    np.testing.assert_allclose(faulty(behaviour)[INSIDE], expected[INSIDE], rtol=0.0, atol=1e-12)


def test_an_outlier_lasts_a_second_where_nothing_is_said():
    _, values = schedule(Outlier(3.0), duration=None).on_channel("yaw_rate", TIME, TRUTH)
    assert np.array_equal(np.flatnonzero(values != TRUTH), np.arange(500, 600))


def test_a_loss_without_end_lasts_to_the_end():
    _, values = schedule(TotalLoss(), duration=None).on_channel("yaw_rate", TIME, TRUTH)
    assert not values[500:].any()


def test_noise_has_its_deviation_and_is_white():
    added = np.concatenate([(faulty(Noise(0.05), seed) - TRUTH)[INSIDE] for seed in range(20)])
    assert np.std(added) == pytest.approx(0.05, rel=0.03)
    assert abs(np.corrcoef(added[1:], added[:-1])[0, 1]) < 0.04


def test_spikes_come_at_their_rate_with_either_sign():
    counts, signs = [], []
    for seed in range(40):
        added = (faulty(Spikes(2.0, rate=3.0, width=0.01), seed) - TRUTH)[INSIDE]
        spikes = added[np.abs(added) > 1e-9]
        np.testing.assert_allclose(np.abs(spikes), 2.0)
        counts.append(len(spikes))
        signs.extend(np.sign(spikes))
    assert np.mean(counts) == pytest.approx(3.0 * (END - START), abs=3.0 * math.sqrt(9.0 / 40.0))
    assert abs(np.mean(signs)) < 0.2


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


def test_an_intermittent_loss_of_frames():
    time, _ = schedule(Intermittent(DropOut(), 0.1, 0.1)).on_channel("yaw_rate", TIME, TRUTH)
    lost = np.setdiff1d(np.arange(2000), np.rint(time * 100).astype(int))
    assert 50 < len(lost) < 250
    assert (np.diff(lost) > 1).sum() > 3


def test_a_fault_cannot_leave_what_the_bus_can_hold():
    speed = np.full(1000, 90.0)
    time = np.arange(1000) / 50.0
    behave = Schedule([Fault("sensor.vehicle_speed", Offset(30.3))], Car(), SENSORS, 0, SECONDS)
    assert set(behave.on_channel("vehicle_speed", time, speed)[1]) == {100.0}
    behave = Schedule([Fault("sensor.vehicle_speed", Offset(-0.3))], Car(), SENSORS, 0, SECONDS)
    assert set(behave.on_channel("vehicle_speed", time, speed)[1]) == {89.5}


def parameter(behaviour, element="steering.level"):
    return schedule(behaviour, element).inputs(TIME).get(f"parameters.{element}")


@pytest.mark.parametrize(
    ("behaviour", "expected"),
    [
        (Step(8.0), np.full(2000, 8.0)),
        (Step("800 N*cm"), np.full(2000, 8.0)),
        (Ramp(8.0, over=2.0), 4.0 + 2.0 * np.minimum(SINCE, 2.0)),
        (Scale(2.5), np.full(2000, 10.0)),
        (Scale(0.5, over=2.0), 4.0 - np.minimum(SINCE, 2.0)),
        (Course((1.0, 2.0), (5.0, "7 N*m")), np.clip(5.0 + 2.0 * (SINCE - 1.0), 5.0, 7.0)),
        (Offset(1.5), np.full(2000, 5.5)),
        (Gain(2.0), np.full(2000, 8.0)),
        (Drift(0.1), 4.0 + 0.1 * SINCE),
        (
            WithTemperature(353.15, time_constant=2.0),
            4.0 * (1.0 + 0.00393 * 60.0 * (1.0 - np.exp(-SINCE / 2.0))),
        ),
    ],
)
def test_a_parameter_changes_as_defined(behaviour, expected):
    values = parameter(behaviour)
    np.testing.assert_allclose(values[INSIDE], expected[INSIDE], rtol=1e-12)
    assert (values[~INSIDE] == 4.0).all()


def test_a_parameter_that_comes_and_goes():
    values = parameter(Intermittent(Step(9.0), 0.2, 0.2))
    assert set(values) == {4.0, 9.0}
    assert values[500] == 9.0


def test_a_sluggish_actuator_is_one_with_another_lag():
    slow = schedule(Sluggish(0.08), "motor_torque")
    assert slow.parameters == ("steering.motor.lag",)
    assert set(slow.inputs(TIME)["parameters.steering.motor.lag"]) == {0.002, 0.08}


def test_a_torque_loss_leaves_the_rest():
    given = schedule(TorqueLoss(0.6), "motor_torque").inputs(TIME)
    assert set(given) == {f"ports.motor_torque.{part}" for part in ("gain", "offset", "held")}
    np.testing.assert_allclose(given["ports.motor_torque.gain"], np.where(INSIDE, 0.4, 1.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: TorqueLoss(1.5), "'share' is 1.5, but has to be above 0 and at most 1"),
        (lambda: DropOut(0.0), "'share' is 0"),
        (lambda: Spikes(1.0, rate=0.0), "'rate' is 0 Hz"),
        (lambda: Delay(0.0), "'time' is 0 s"),
        (lambda: Noise(-1.0), "'deviation' is -1"),
        (lambda: BitFlip(16), "bit 16 does not exist among 16 bits"),
        (lambda: BitFlip(-1), "'bit' is -1"),
        (lambda: Sluggish(0.0), "'time_constant' is 0 s"),
        (lambda: Ramp(1.0, over=0.0), "'over' is 0 s"),
        (lambda: Course((1.0,), (1.0, 2.0)), "as many values as times"),
        (lambda: Course((), ()), "as many values as times"),
        (lambda: Course((2.0, 1.0), (1.0, 2.0)), "ascending"),
        (lambda: WithTemperature(-3.0), "'temperature' is -3 K"),
        (lambda: Intermittent(Intermittent(Gain(1.0))), "cannot itself be intermittent"),
    ],
)
def test_impossible_behaviours_are_refused(make, words):
    with pytest.raises(ParameterError, match=words):
        make()


@pytest.mark.parametrize("kind", BEHAVIOURS.values(), ids=list(BEHAVIOURS))
def test_every_behaviour_fits_something_and_its_size_is_a_field(kind):
    assert issubclass(kind, Behaviour)
    assert kind is Intermittent or kind.fits
    assert kind.main is None or kind.main in kind.__dataclass_fields__
    assert kind.__doc__
