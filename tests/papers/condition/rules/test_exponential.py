from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from tierod.core.errors import ParameterError
from tierod.models.single_track import SingleTrack
from tierod_lab.papers.condition.rules.rack import discretise_pair


class Pair(NamedTuple):
    a: float
    b: float


class Push(NamedTuple):
    u: float


@dataclass(frozen=True)
class Matrix:
    a: float
    b: float
    c: float
    d: float


class Linear:
    """x' = A x + (1, 2) u."""

    State, Input, Output, Parameters = Pair, Push, Push, Matrix

    @staticmethod
    def derivative(x, u, p):
        return Pair(p.a * x.a + p.b * x.b + u.u, p.c * x.a + p.d * x.b + 2.0 * u.u)

    @staticmethod
    def output(x, u, p):
        return Push(x.a)


def exact(matrix, x, u, step):
    whole = np.zeros((3, 3))
    whole[:2, :2] = np.reshape(matrix, (2, 2))
    whole[:2, 2] = u, 2.0 * u
    return (expm(step * whole) @ [*x, 1.0])[:2]


@pytest.mark.parametrize(
    "matrix",
    [
        (-1.0, 0.5, 0.2, -3.0),
        (0.0, 1.0, -900.0, -2.0),
        (-2.0, 1.0, 0.0, -2.0),
        (-2.0, 1.0, 0.0, -2.0 - 1e-7),
        (-560.0, 3.0, 8.0, -400.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, -800.0),
        (1e-9, 1.0, 1e-8, -30.0),
        (-300.0, 100.0, 150.0, -50.0),
        (-2e5, 1.0, 2.0, -1.0),
    ],
)
def test_a_sample_is_the_exponential(matrix):
    model = discretise_pair(Linear)
    p = model.Parameters(Matrix(*matrix), 0.01)
    after = model.transition(Pair(0.3, -0.7), Push(1.5), p)
    assert after == pytest.approx(exact(matrix, (0.3, -0.7), 1.5, 0.01), rel=1e-8)


def test_the_printed_tyres_do_not_blow_up_at_walking_speed():
    model = discretise_pair(SingleTrack)
    p = model.Parameters(SingleTrack.Parameters(403.2, 548.3, 0.904, 1.166, 321839.0, 321839.0), 0.01)
    x = SingleTrack.State(0.0, 0.0)
    for _ in range(50):
        x = model.transition(x, SingleTrack.Input(0.1, 2.0), p)
    assert x.yaw_rate == pytest.approx(2.0 * 0.1 / 2.07, rel=0.01)


def test_other_numbers_of_states_are_refused():
    class One(NamedTuple):
        a: float

    class Single(Linear):
        State = One

    with pytest.raises(ParameterError, match="1 states"):
        discretise_pair(Single)
    with pytest.raises(ParameterError, match="derivative"):
        discretise_pair(object)
