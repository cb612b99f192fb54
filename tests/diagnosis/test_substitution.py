from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan, trace
from tierod.diagnosis.switchover import HELD, SENSOR, Switchover, graph_from

SAMPLE_TIME = 0.01
FADE = 0.1
NAN = math.nan


def way(name, needs=(), deviation=1.0):
    return {"name": name, "needs": list(needs), "deviation": deviation, "source": "made up"}


TABLE = {
    "left": [way("right-and-yaw", ["right", "yaw"], 0.1), way("model", (), 0.5)],
    "right": [way("model", (), 0.5), way("left-and-yaw", ["left", "yaw"], 0.1)],
    "yaw": [way("wheels", ["left", "right"], 0.02)],
}
GRAPH = graph_from(TABLE)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"a": [way("x", ["b"])]}, "needs 'b'"),
        ({"a": [way("x", ["a"])]}, "needs 'a' itself"),
        ({"a": [way("x"), way("x")]}, "two substitutes 'x'"),
        ({"a": [way("x", deviation=0.0)]}, "above zero"),
        ({"a": [{"name": "x", "needs": [], "deviation": 1.0}]}, "lacks 'source'"),
        ({"a": [{**way("x"), "deviaton": 1.0}]}, "no 'deviaton'.*deviation"),
    ],
)
def test_a_graph_that_cannot_be_meant_is_refused(table, message):
    with pytest.raises(ParameterError, match=message):
        graph_from(table)


SWITCH = Switchover(GRAPH, (2.0, 2.0, 0.1), FADE, SAMPLE_TIME)


def driven(count, **columns):
    """Outputs over `count` samples; columns as "left_faulty", all else without fault at 10, 20, 0.5."""
    usual = {
        "left": (10.0, 0.0, 10.3, 9.0),
        "right": (20.0, 0.0, 20.2, 22.0),
        "yaw": (0.5, 0.0, 0.55),
    }
    values = np.tile(np.concatenate([usual[name] for name in usual]), (count, 1))
    order = trace(SWITCH).sample
    for name, column in columns.items():
        values[:, order.index(name.replace("__", "."))] = column
    return scan(SWITCH, values)


def after(count, start, value, before=0.0):
    return np.where(np.arange(count) >= start, value, before)


def test_a_faulty_sensor_is_replaced_at_once_and_without_a_trace_of_its_wrong_value():
    substituted = driven(20, left__faulty=after(20, 5, 1.0), left__measured=after(20, 5, 0.0, 10.0))
    assert np.all(substituted["left.value"][5:] == 10.3)
    assert np.all(substituted["left.source"][5:] == 1.0)
    assert np.all(substituted["left.deviation"][5:] == 0.1)


def test_back_to_the_sensor_without_a_bump():
    faulty = after(200, 5, 1.0) - after(200, 50, 1.0)
    value = driven(200, left__faulty=faulty)["left.value"]
    assert value[50] == pytest.approx(10.3)
    steps = np.abs(np.diff(value[49:]))
    assert steps.max() < 0.3 * SAMPLE_TIME / FADE * 1.01
    at_one_time_constant = 50 + round(FADE / SAMPLE_TIME)
    assert value[at_one_time_constant] - 10.0 == pytest.approx(0.3 * math.exp(-1.0), rel=0.06)
    assert value[-1] == pytest.approx(10.0, abs=1e-6)


def test_from_one_substitute_to_the_next_without_a_bump_and_with_its_larger_deviation():
    substituted = driven(300, left__faulty=1.0, yaw__faulty=after(300, 100, 1.0))
    assert substituted["left.source"][[99, 100]].tolist() == [1.0, 2.0]
    assert substituted["left.value"][100] == pytest.approx(10.3)
    assert substituted["left.deviation"][100] == pytest.approx(math.hypot(0.5, 1.3))
    assert substituted["left.value"][-1] == pytest.approx(9.0, abs=1e-3)
    assert substituted["left.deviation"][-1] == pytest.approx(0.5, rel=1e-3)


def test_with_nothing_left_the_last_value_is_held_and_grows_uncertain():
    substituted = driven(60, yaw__faulty=after(60, 10, 1.0), left__faulty=after(60, 20, 1.0), left__model=NAN)
    assert substituted["yaw.source"][[9, 10, 19, 20]].tolist() == [SENSOR, 1.0, 1.0, HELD]
    assert np.all(substituted["yaw.value"][20:] == substituted["yaw.value"][19])
    grown = substituted["yaw.deviation"][59] - substituted["yaw.deviation"][19]
    assert grown == pytest.approx(0.1 * 40 * SAMPLE_TIME)
