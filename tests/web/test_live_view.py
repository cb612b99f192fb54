"""The live view: frames become samples, lines reach every page, and a slow page loses its oldest."""

import asyncio
import json
import queue

import numpy as np
import pytest

from live_drives import database_file, drive, messages
from tierod.live.clock import Frame
from tierod.live.drive import Drive
from tierod.live.events import Hub
from tierod.live.judge import Plan
from tierod.live.outputs import Outputs
from tierod.vehicles import load
from tierod.web.following import Samples
from tierod.web.relay import KEPT, WAITING, Relay


def frames(folder):
    """The first second of the drive's EPS message."""
    (eps, *_) = messages(folder)
    part = drive(1.0)
    names = ("driver_torque", "motor_torque", "steering_wheel_angle", "steering_wheel_rate")
    for at, time in enumerate(part["driver_torque"].time):
        values = {name: float(part[name].values[at]) for name in names}
        yield Frame(float(time), 256, 1, bytes(eps.encode(values)))


def test_frames_become_samples_of_every_signal(tmp_path):
    samples = Samples(messages(tmp_path), None)
    sent = list(frames(tmp_path))
    samples.heard(sent[:60])
    found = samples.content()
    assert found is not None
    part = drive(1.0)["driver_torque"]
    np.testing.assert_allclose(found["driver_torque"]["values"], part.values[:60], atol=6e-4)
    np.testing.assert_allclose(found["driver_torque"]["time"], part.time[:60], atol=1e-4)
    assert found["driver_torque"]["unit"] == "N*m"
    assert samples.content() is None
    samples.heard([Frame(2.0, 999, 1, b"12345678")])
    assert samples.content() == {}


def test_an_engine_gives_its_frames_to_who_listens(tmp_path):
    got = []
    made = Drive([], None, messages(tmp_path), None, ["friction"], Plan(load("midsize-eps")), Outputs(), Hub())  # type: ignore[arg-type]
    made.engine.heard = got.extend
    sent = list(frames(tmp_path))
    made.engine.clock.begin(sent[0], 0.0, 1_700_000_000.0)
    made.engine.take(sent[:10], 0.0, 1_700_000_000.0)
    assert [each.data for each in got] == [each.data for each in sent[:10]]


def test_who_follows_ends_with_the_server(tmp_path, monkeypatch, capsys):
    import os

    from tierod.web.following import follow

    plan = Plan(load("midsize-eps"))
    made = Drive([], queue.SimpleQueue(), messages(tmp_path), None, ["friction"], plan, Outputs(), Hub())
    parents = iter([7, 7])
    monkeypatch.setattr(os, "getppid", lambda: next(parents, 1))
    monkeypatch.setattr("signal.signal", lambda *_: None)
    assert follow(made, Samples(messages(tmp_path), None)) == 2
    assert made.ended


def test_a_page_that_comes_later_gets_what_came_lately():
    async def run():
        relay = Relay([])
        for number in range(KEPT + 50):
            relay.give(str(number))
        queue = relay.listen()
        assert queue.get_nowait() == "50"
        for number in range(WAITING + 100):
            relay.give(f"new {number}")
        assert queue.qsize() == KEPT + WAITING
        relay.leave(queue)
        relay.give("gone")
        assert queue.qsize() == KEPT + WAITING

    asyncio.run(run())


@pytest.mark.parametrize("words", [["-c", "import sys; sys.exit('tierod: no bus')"], ["-c", ""]])
def test_a_process_that_ends_is_a_sentence(words):
    async def run():
        relay = Relay(words)
        await relay.begin()
        queue = relay.listen()
        said = json.loads(await asyncio.wait_for(queue.get(), 20.0))
        assert said["event"] == "problem"
        assert "start it again" in said["text"]
        await relay.end()

    asyncio.run(run())


def test_a_bus_that_is_none_is_a_sentence(tmp_path, capsys, monkeypatch):
    from tierod.web import following

    words = ["following", "--vehicle", "midsize-eps", "--dbc", str(database_file(tmp_path)), "--live", "nobus:0"]
    monkeypatch.setattr("sys.argv", words)
    assert following.main() == 3
    assert "no interface 'nobus'" in json.loads(capsys.readouterr().out)["text"]
