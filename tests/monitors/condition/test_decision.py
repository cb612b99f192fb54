"""The judge over made-up lanes that know every sensor's truth: who is named, when, and what happens to the lanes."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tierod.errors import ParameterError
from tierod.graph import Bank, scan
from tierod.graph.maths import both, log, present, sqrt, where
from tierod.monitors.condition.decision import judge
from tierod.monitors.condition.lane import LeaveOutFilter, Readings, Surprise
from tierod.monitors.condition.signals import SENSORS, ConditionSample, Hypothesis
from tierod.monitors.condition.weighing import Limits, Weighing

LEFT, RIGHT, YAW, ANGLE, TORQUE, FORCE = SENSORS
MOTOR_1, MOTOR_2 = "steering_motor_1", "steering_motor_2"
HYPOTHESES = (
    Hypothesis("healthy"),
    *(Hypothesis(name, (name,)) for name in (LEFT, RIGHT, TORQUE)),
    *(Hypothesis(name, (), (name,)) for name in (MOTOR_1, MOTOR_2)),
    Hypothesis("both wheels", (LEFT, RIGHT)),
    Hypothesis("left and motor 1", (LEFT,), (MOTOR_1,)),
)
NOISE, WIDTH = (0.03, 0.03, 0.003, 0.01, 0.1, 20.0), (30.0, 30.0, 4.0, 16.0, 60.0, 4000.0)
RATE = 100.0


@dataclass(frozen=True)
class Lane:
    """The speed is estimated from the wheels that are used, all else is known; one share of torque may be lost."""

    use_left: float = 1.0
    use_right: float = 1.0
    use_torque: float = 1.0
    trust_1: float = 1.0
    trust_2: float = 1.0
    Sample = ConditionSample

    def init(self):
        return 10.0, 0.0, 0.5

    def step(self, state, sample):
        speed, loss, variance = state
        speed = speed + where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0) / RATE
        asked = sample.steering_motor_1_target_torque, sample.steering_motor_2_target_torque
        lost = where(self.trust_1 > 0.5, 0.0, asked[0]) + where(self.trust_2 > 0.5, 0.0, asked[1])
        torque = asked[0] + asked[1] - loss * lost
        expected = Readings(speed, speed, sample.target_steering_wheel_angle, 1.0, torque, 500.0)
        uses = (self.use_left, self.use_right, 1.0, 1.0, self.use_torque, 1.0)
        used = [both(present(reading), use > 0.5) for reading, use in zip(sample, uses, strict=False)]
        off = [where(use, y - value, 0.0) for use, y, value in zip(used, sample, expected, strict=False)]
        spread = [noise * noise for noise in NOISE]
        spread[4] = spread[4] + variance * lost * lost
        likelihood = 0.0
        for use, reading, error, square, width in zip(used, sample, off, spread, WIDTH, strict=False):
            inside = -0.5 * (error * error / square + log(2.0 * math.pi * square))
            likelihood = likelihood + where(use, inside, where(present(reading), -log(width), 0.0))
        speed = speed + 0.2 * (off[0] + off[1])
        gain = where(used[4], variance * lost / spread[4], 0.0)
        loss, variance = loss - gain * off[4], (1.0 - gain * lost) * variance + 0.01
        after = Readings(speed, speed, *expected[2:])
        output = LeaveOutFilter.Output(
            likelihood, expected, Readings(*NOISE), after, Surprise(*(0.0,) * 6), loss, sqrt(variance), speed, 0.0
        )
        return (speed, loss, variance), output


def lane(hypothesis):
    uses = {f"use_{short}": 0.0 for short, name in zip(("left", "right", "torque"), (LEFT, RIGHT, TORQUE), strict=True)
            if name in hypothesis.sensors}  # fmt: skip
    trusts = {f"trust_{name[-1]}": 0.0 for name in hypothesis.actuators}
    return Lane(**uses, **trusts)


@pytest.fixture(scope="module")
def bank():
    count = len(HYPOTHESES) - 1
    limits = Limits((3.0,) * count, (1.0,) * count, gap=1.0, margin=1.0)
    return Bank(tuple(map(lane, HYPOTHESES)), judge(HYPOTHESES, limits))


@pytest.fixture
def drive():
    """Ten seconds at 10 m/s; the torque is split unequally, by turns."""
    time, chance = np.arange(1000) / RATE, np.random.default_rng(5)
    swing = np.where(time % 0.24 < 0.12, 0.65, 0.35)
    total = 4.0 + 2.0 * np.sin(time)
    values = np.zeros((1000, len(ConditionSample._fields)))
    values[:, :2], values[:, 3], values[:, 5] = 10.0, 1.0, 500.0
    values[:, 12] = values[:, 2] = 0.3 * np.sin(0.5 * time)
    values[:, 4], values[:, 8], values[:, 9] = total, swing * total, (1.0 - swing) * total
    values[:, :6] += chance.normal(size=(1000, 6)) * NOISE
    return values


def column(name):
    return ConditionSample._fields.index(name)


def declared(result):
    """(time, name) of every change of the declared hypothesis."""
    numbers = result["hypothesis"].astype(int)
    return [(k / RATE, HYPOTHESES[numbers[k]].name) for k in np.flatnonzero(np.diff(numbers, prepend=-1))]


def test_nothing_is_declared_where_nothing_is_at_fault(bank, drive):
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    assert not any(result[f"candidates.{name}"].any() for name in SENSORS)
    np.testing.assert_array_equal(result[f"value.{LEFT}"], drive[:, 0])


@pytest.mark.parametrize("name", [LEFT, RIGHT])
@pytest.mark.parametrize("size", [1.0, -1.0])
def test_an_offset_is_declared_within_a_tenth_of_a_second_and_taken_back_after_it(bank, drive, name, size):
    drive[300:700, column(name)] += size
    (_, first), (at, second), (back, third) = declared(scan(bank, drive))
    assert (first, second, third) == ("healthy", name, "healthy")
    assert 3.0 < at < 3.1
    assert 7.2 < back < 7.5


def test_a_lost_sensor_is_replaced_from_the_first_sample_on(bank, drive):
    drive[300:, 0] = 0.0
    result = scan(bank, drive)
    assert np.abs(result[f"value.{LEFT}"][300:] - 10.0).max() < 0.1
    assert (result["speed"][300:] > 9.9).all(), "lanes that believe the sensor are corrected from others"
    assert result[f"gated.{LEFT}"][300] == 1.0


def test_a_single_outlier_is_gated_and_not_declared(bank, drive):
    drive[300, 0] += 5.0
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    np.testing.assert_array_equal(np.flatnonzero(result[f"gated.{LEFT}"]), [300])
    assert abs(result["speed"][301] - 10.0) < 0.05


def test_one_after_another_becomes_a_pair_and_each_recovers_by_itself(bank, drive):
    drive[300:600, 0] = 0.0
    drive[400:800, 1] += 2.0
    names = [name for _, name in declared(scan(bank, drive))]
    assert names == ["healthy", LEFT, "both wheels", RIGHT, "healthy"]


def test_a_lost_sensor_does_not_recover_while_it_should_read_zero(bank, drive):
    drive[400:600, column("longitudinal_acceleration")] = -5.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / RATE
    drive[300:, 0] = 0.0
    result = scan(bank, drive)
    assert declared(result)[-1][1] == LEFT
    assert result[f"testable.{LEFT}"][350] == 1.0
    assert result[f"testable.{LEFT}"][-50:].max() == 0.0


@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize("name", [MOTOR_1, MOTOR_2])
def test_a_motor_is_told_from_the_other_by_the_swing_of_their_split(bank, drive, name, share):
    drive[300:700, column(TORQUE)] -= share * drive[300:700, column(f"{name}_target_torque")]
    result = scan(bank, drive)
    names = [name for _, name in declared(result)]
    assert names == ["healthy", name, "healthy"]
    assert result["torque_loss"][690] == pytest.approx(share, abs=0.05)


def test_motors_that_share_alike_are_named_together(bank, drive):
    drive[:, 8] = drive[:, 9] = 0.5 * (drive[:, 8] + drive[:, 9])
    drive[300:700, column(TORQUE)] -= 0.5 * drive[300:700, 8]
    result = scan(bank, drive)
    both_named = (result[f"candidates.{MOTOR_1}"] > 0.0) & (result[f"candidates.{MOTOR_2}"] > 0.0)
    assert both_named[310:700].all()
    assert not result[f"faulty.{MOTOR_1}"].any()


def test_missing_readings_accuse_nobody(bank, drive):
    drive[300:500, 0] = np.nan
    drive[600:650] = np.nan
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    assert np.isfinite(result[f"value.{LEFT}"]).all()


def test_limits_are_one_for_each_hypothesis():
    with pytest.raises(ParameterError, match="6 fast limits came for 7 hypotheses"):
        Weighing(HYPOTHESES, Limits((1.0,) * 6, (1.0,) * 7, 1.0, 1.0))


def test_a_larger_gap_makes_it_wait(bank, drive):
    drive[300:, column(TORQUE)] -= 0.5
    weighing = bank.judge.weighing
    careful = replace(bank.judge, weighing=replace(weighing, limits=replace(weighing.limits, gap=1e3)))
    result = scan(replace(bank, judge=careful), drive)
    assert declared(result) == [(0.0, "healthy")]
    assert result[f"candidates.{TORQUE}"][400:].all()
