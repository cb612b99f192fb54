import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.proving_ground.cars.column_bench import ColumnBench
from tierod.proving_ground.courses.bench import BenchHands
from tierod.proving_ground.run import run


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
