"""Sessions for moved vehicles, in the lanes of one kernel or one after the other."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.graph import batch, scan
from tierod.core.graph.lanes import FEWEST
from tierod.core.recording import Aligned
from tierod.monitors.harness.session import opened
from tierod.monitors.harness.spread import points
from tierod.monitors.harness.spread.points import Points
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load
from tierod_lab.ground import drive

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

PARAMETERS = ("tire_damping", "column_damping", "steering_ratio", "motor_ratio", "mass")


@pytest.fixture(scope="module")
def recording():
    return drive(minutes=1.0, seed=2)


def sessions(name):
    car, monitor = load("midsize-eps"), MONITORS[name]
    moves = [{}, *({each: side} for each in PARAMETERS if each in car.parameters for side in (1.0, -1.0))]
    return Points(lambda moved: opened(monitor, monitor.variants[monitor.default], moved), car, moves), monitor


def run(name, recording, monkeypatch, lanes_from):
    """Traces of every vehicle and what it concludes, over pieces of a recording."""
    monkeypatch.setattr(points, "LANES_FROM", lanes_from)
    found, monitor = sessions(name)
    signals = found.running[0].session.signals
    shown = []
    for start, stop in ((0.0, 20.0), (20.0, 40.0), (40.0, 60.0)):
        shown.append(found.absorb(recording.align(signals, monitor.rate, maximum_age=0.1, start=start, stop=stop)))
    return shown, found.conclude(), found


@pytest.mark.parametrize("name", ["friction", "sideslip", pytest.param("driver-torque", marks=pytest.mark.slow)])
def test_vehicles_side_by_side_give_what_each_gives_alone_to_the_last_bit(name, recording, monkeypatch):
    alone, concluded, _ = run(name, recording, monkeypatch, np.inf)
    abreast, same, found = run(name, recording, monkeypatch, 0)
    assert len(found.running) > FEWEST
    for one, other in zip(alone, abreast, strict=True):
        assert list(one) == list(other)
        for place, traces in one.items():
            assert traces.keys() == other[place].keys()
            for trace, values in traces.items():
                np.testing.assert_array_equal(values, other[place][trace], err_msg=trace)
    assert {place: each.conclusion.verdict for place, each in concluded.items()} == {
        place: each.conclusion.verdict for place, each in same.items()
    }


@pytest.mark.parametrize("where", ["prepared", "taken"])
def test_one_that_its_monitor_refuses_is_left_out_and_the_others_go_on(where, recording, monkeypatch):
    monkeypatch.setattr(points, "LANES_FROM", 0)
    found, monitor = sessions("friction")
    signals = found.running[0].session.signals
    first, second = (
        recording.align(signals, monitor.rate, maximum_age=0.1, start=start, stop=start + 30.0) for start in (0.0, 30.0)
    )
    found.absorb(first)

    def refuse(*_):
        raise InputError("refused")

    monkeypatch.setattr(found.running[1].session, where, refuse)
    others = [place for place in found.running if place != 1]
    assert list(found.absorb(second)) == others == list(found.running)


def test_the_kernels_of_lanes_follow_a_block_that_is_fitted_anew(recording, monkeypatch):
    monkeypatch.setattr(points, "LANES_FROM", 0)
    found, monitor = sessions("friction")
    session = found.running[2].session
    aligned = recording.align(session.signals, monitor.rate, maximum_age=0.1)
    parts = [Aligned(aligned.time[at], aligned.values[at], aligned.names) for at in (slice(0, 4000), slice(4000, None))]
    found.absorb(parts[0])
    memory, other = session.memory, found.running[3].session.block
    session.block = other
    shown = found.absorb(parts[1])[2]
    expected = scan(other, parts[1], memory)
    np.testing.assert_array_equal(shown["friction_torque"], expected["estimate.friction_torque"])
    (one,) = batch([other], [parts[1]], [memory])
    np.testing.assert_array_equal(one.values, expected.values)


@pytest.mark.parametrize(("count", "abreast"), [(points.AT_ONCE, True), (points.AT_ONCE - 1, False)])
def test_short_pieces_as_those_of_a_live_drive_wait_for_no_further_kernel(count, abreast, recording, monkeypatch):
    monkeypatch.setattr(points, "LANES_FROM", 0)
    found, monitor = sessions("friction")
    aligned = recording.align(found.running[0].session.signals, monitor.rate, maximum_age=0.1)
    parts = [points.part_of(aligned, start, start + count) for start in (0, count)]
    found.absorb(parts[0])
    taken = []
    monkeypatch.setattr(found._lanes, "scan", lambda blocks, *given: taken.append(blocks) or batch(blocks, *given))
    found.absorb(parts[1])
    assert bool(taken) is abreast


def test_moved_vehicles_are_fitted_to_what_the_session_of_the_file_was(recording):
    found, monitor = sessions("driver-torque")
    session = opened(monitor, monitor.variants[monitor.default], load("midsize-eps"))
    found.fit_as(session)
    assert all(each.session.fitted is None for each in found.running.values())
    session.absorb(recording.align(session.signals, monitor.rate, maximum_age=0.1))
    found.fit_as(session)
    assert all(each.session.fitted == session.fitted for each in found.running.values())
    short = recording.align(session.signals, monitor.rate, maximum_age=0.1, stop=30.0)
    found.absorb(short)
    assert all(each.session.fitted == session.fitted for each in found.running.values())
