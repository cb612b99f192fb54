import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.methods.analysis.parameter_bound import parameter_bound
from tierod.models.discretise import discretise
from tierod.models.steering_column import SteeringColumn
from tierod.papers.column.parameter_sets import SETS

NOISE = {"steering_wheel_angle": 8.7e-4, "motor_angle_mechanical": 3.5e-3, "driver_torque": 0.02}


@dataclass(frozen=True)
class GainParameters:
    gain: float
    offset: float


class Push(NamedTuple):
    push: float


class Level(NamedTuple):
    level: float


class Read(NamedTuple):
    read: float


class Gain:
    """A level that rests, read with a gain on the push and an offset."""

    State, Input, Output, Parameters = Level, Push, Read, GainParameters

    @staticmethod
    def transition(x, u, p):
        return x

    @staticmethod
    def output(x, u, p):
        return Read(x.level + p.gain * u.push + p.offset)


PUSHES = np.linspace(-1.0, 3.0, 50)[:, None]


def gain_bound(**free):
    asked = {"free": (), "free_states": ()} | free
    return parameter_bound(Gain, GainParameters(2.0, 0.5), Level(0.0), PUSHES, {"read": 0.1}, **asked)


def test_a_gain_is_the_slope_of_a_line():
    alone = gain_bound(free=("gain",))
    assert alone["gain"] == pytest.approx(0.1 / math.sqrt((PUSHES**2).sum()))
    both = gain_bound(free=("gain", "offset"))
    assert both["gain"] == pytest.approx(0.1 / math.sqrt(50 * PUSHES.var()))
    assert both.names == ("gain", "offset")


def test_what_cannot_be_told_apart_has_no_bound():
    found = gain_bound(free=("gain", "offset"), free_states=("level",))
    assert np.isinf([found["offset"], found["level"]]).all()
    assert math.isfinite(found["gain"])


def column_bound(inputs, free):
    model = discretise(SteeringColumn, "rk4", 2)
    parameters = model.Parameters(SETS["S1"], 1e-3)
    return parameter_bound(model, parameters, model.State(*[0.0] * 6), inputs, NOISE, free)


def test_the_bound_is_that_of_differences_of_simulations():
    from dataclasses import replace

    from tierod.core.graph import scan
    from tierod.methods.identification.simulation import Simulation

    inputs = np.zeros((400, 3))
    inputs[:, 0] = np.random.default_rng(3).normal(size=400)
    model = discretise(SteeringColumn, "rk4", 2)

    def simulated(damping):
        parameters = model.Parameters(replace(SETS["S1"], motor_damping=damping), 1e-3)
        return scan(Simulation(model, parameters, model.State(*[0.0] * 6)), inputs).values[:, :3]

    damping, step = SETS["S1"].motor_damping, 1e-6
    slope = (simulated(damping + step) - simulated(damping - step)) / (2.0 * step) / np.array(list(NOISE.values()))
    found = column_bound(inputs, ("continuous.motor_damping",))
    assert found.end[0] == pytest.approx(1.0 / math.sqrt((slope**2).sum()), rel=1e-3)


def test_a_bench_at_rest_tells_nothing():
    found = column_bound(np.zeros((50, 3)), ("continuous.motor_damping", "continuous.steering_wheel_damping"))
    assert np.isinf(found.end).all()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"noise": {"red": 0.1}}, "no output 'red'; did you mean 'read'"),
        ({"noise": {"read": 0.0}}, "no noise above zero is given for read"),
        ({"noise": {}}, "any output"),
        ({"free": ("gian",)}, "gian"),
        ({"free_states": ("levle",)}, "no state 'levle'"),
    ],
)
def test_wrong_names_and_noises_are_refused(change, sentence):
    asked = {"noise": {"read": 0.1}, "free": ("gain",)} | change
    with pytest.raises(ParameterError, match=sentence):
        parameter_bound(Gain, GainParameters(2.0, 0.5), Level(0.0), PUSHES, **asked)
