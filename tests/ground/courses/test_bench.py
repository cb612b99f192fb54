import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.cars.column_bench import ColumnBench
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.courses.bench import BenchHands, BenchMultisine, BenchRamps, BenchSteps, BenchSweep
from tierod_lab.ground.run import run


def frequency(sweep, at):
    time = np.arange(at - 0.5, at + 0.5, 1e-4)
    torque = sweep.columns(time, 0.0 * time, 0.0, 0.0)["motor_torque"]
    up = time[1:][(torque[:-1] < 0.0) & (torque[1:] >= 0.0)]
    return (len(up) - 1) / (up[-1] - up[0])


def test_the_sweep_passes_its_frequencies_at_an_even_pace_of_octaves():
    sweep = BenchSweep(amplitude=0.5, lowest=4.0, highest=32.0, settle=1.0, time=31.0)
    assert [frequency(sweep, at) for at in (11.0, 21.0)] == pytest.approx([8.0, 16.0], rel=0.03)
    time = np.linspace(0.0, 31.0, 5000)
    torque = sweep.columns(time, time, 0.0, 0.0)["motor_torque"]
    assert np.all(torque[time < 1.0] == 0.0)
    assert np.max(np.abs(torque)) == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize(("wheel", "locked", "grip"), [("free", 0.0, 0.0), ("locked", 1.0, 0.0), ("held", 0.0, 1.0)])
def test_the_wheel_is_what_is_said(wheel, locked, grip):
    columns = BenchSweep(wheel=wheel).columns(np.zeros(1), np.zeros(1), 0.0, 0.0)
    assert (columns["locked"][0], columns.get("grip", [0.0])[0]) == (locked, grip)


def test_a_motor_alone_can_be_swept():
    outcome = run(MotorBench(), BenchSweep(amplitude=0.1, lowest=1.0), 3.0)
    assert outcome.diverged_at is None
    constant = 1.5 * 4 * 0.0085  # 3/2 times pole pairs times flux: torque per ampere along the axis beta at angle 0
    assert np.max(outcome.recording["truth_motor_current_beta"].values) == pytest.approx(0.1 / constant, rel=0.02)


def test_a_locked_wheel_stays_while_the_motor_turns():
    outcome = run(ColumnBench(), BenchSweep(wheel="locked"), 5.0)
    assert outcome.diverged_at is None
    assert np.max(np.abs(outcome.recording["truth_steering_wheel_angle"].values)) < 1e-9
    assert np.max(np.abs(outcome.recording["truth_motor_angle_mechanical"].values)) > 1e-3


@pytest.mark.parametrize(
    ("wrong", "words"), [({"lowest": 40.0}, "has no band"), ({"time": 0.5, "settle": 1.0}, "before it has settled")]
)
def test_a_sweep_that_cannot_be(wrong, words):
    with pytest.raises(ParameterError, match=words):
        BenchSweep(**wrong)


def test_a_constant_load_on_the_gear():
    columns = BenchSweep(gear_torque=-2.0).columns(np.zeros(2), np.zeros(2), 0.0, 0.0)
    assert columns["gear_torque"].tolist() == [-2.0, -2.0]
    assert math.isclose(BenchSweep().duration, 61.0)


def torque_of(test):
    time = np.arange(0.0, test.duration, 1e-3)
    return time, test.columns(time, time, 0.0, 0.0)["motor_torque"]


def test_ramps_are_straight_and_grow():
    time, torque = torque_of(BenchRamps(amplitude=0.4, period=4.0, first=0.25, settle=1.0, time=21.0))
    assert np.all(torque[time < 1.0] == 0.0)
    assert np.max(torque[time < 5.0]) == pytest.approx(0.4 * (0.25 + 0.75 * 1.0 / 20.0), rel=1e-3)
    assert np.max(np.abs(torque)) == pytest.approx(0.4 * (0.25 + 0.75 * 19.0 / 20.0), rel=1e-3)
    assert np.max(np.abs(np.diff(torque, 2)[(time[1:-1] > 1.1) & (time[1:-1] < 1.9)])) < 1e-6


def test_steps_go_left_nowhere_right_nowhere():
    time, torque = torque_of(BenchSteps(amplitude=0.2, hold=0.5, settle=1.0, time=5.0))
    assert [torque[np.searchsorted(time, at)] for at in (0.5, 1.25, 1.75, 2.25, 2.75, 3.25)] == [
        *(0.0, 0.2, 0.0, -0.2, 0.0, 0.2)
    ]


def test_a_multisine_has_the_power_of_one_sine_and_no_high_peak():
    _, torque = torque_of(BenchMultisine(amplitude=0.3, settle=0.0, time=60.0))
    assert np.std(torque) == pytest.approx(0.3 / math.sqrt(2.0), rel=0.02)
    assert np.max(np.abs(torque)) < 4.0 * np.std(torque)


def test_a_test_shorter_than_its_settling_is_refused():
    with pytest.raises(ParameterError, match="before it has settled"):
        BenchSteps(time=0.5, settle=1.0)


def columns(course, time):
    return course.columns(time, 0.0 * time, 0.0, 0.0)


def test_hands_come_and_go_within_their_times():
    course = BenchHands(time=400.0, shortest=2.0, longest=8.0, seed=3)
    times = np.diff(course.switches, prepend=0.0)
    assert 2.0 <= times.min() < times.max() <= 8.0
    middles = course.switches[:-1] + 0.5 * times[1:]
    present, hold = course.held(middles)
    assert present.tolist() == [1.0, 0.0] * (len(middles) // 2) + [1.0] * (len(middles) % 2)
    assert hold[::2].tolist() == list(range(len(middles[::2])))


def test_without_hands_there_is_no_torque_and_no_grip():
    course = BenchHands(time=100.0, seed=1)
    time = np.arange(100_000) * 1e-3
    given, (present, _) = columns(course, time), course.held(time)
    assert np.all(given["hand_torque"][present == 0.0] == 0.0)
    assert np.all(given["grip"][present == 0.0] == 0.0)
    assert np.all(given["grip"][present == 1.0] >= 0.5)


def test_the_torque_of_a_hold_is_within_what_was_asked_for():
    course = BenchHands(time=3000.0, lightest=0.2, firmest=0.2, tremor=0.0, seed=2)
    time = np.arange(300_000) * 1e-2
    present, _ = course.held(time)
    deviation = np.std(columns(course, time)["hand_torque"][present == 1.0])
    assert 0.13 < deviation < 0.2  # 0.2 at the knots, less between them


def test_pieces_are_the_same_as_the_whole():
    course = BenchHands(seed=5)
    time = np.arange(4000) * 1e-2
    whole = columns(course, time)
    for name, values in whole.items():
        parts = [columns(course, piece)[name] for piece in np.split(time, 8)]
        np.testing.assert_array_equal(np.concatenate(parts), values)


def test_the_bench_bears_it():
    outcome = run(ColumnBench(), BenchHands(time=60.0, seed=4))
    assert outcome.diverged_at is None
    assert np.max(np.abs(outcome.recording["truth_hand_torque"].values)) > 0.1


@pytest.mark.parametrize(
    ("wrong", "words"), [({"lightest": 2.0}, "must not be greater"), ({"ramp": 5.0}, "at least twice the ramp")]
)
def test_hands_that_cannot_be(wrong, words):
    with pytest.raises(ParameterError, match=words):
        BenchHands(**wrong)
