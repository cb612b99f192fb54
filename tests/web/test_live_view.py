"""The live view: frames become samples, lines reach every page, and a slow page loses its oldest."""

import asyncio
import json
import shutil
import subprocess

import numpy as np
import pytest

from live_drives import database_file, drive, messages
from tierod.core.findings import Diagnosis, Finding, Status
from tierod.live.clock import Frame
from tierod.report import to_json
from tierod.web.following import Samples
from tierod.web.relay import Relay


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


DRAWN = """
import { lanes } from "./findings.js";
let text = "";
process.stdin.on("data", (part) => { text += part; });
process.stdin.on("end", () => { console.log(JSON.stringify(lanes(JSON.parse(text), [0, 60]))); });
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    pytest.importorskip("fastapi", reason="the extra 'web' is not installed")
    from tierod.web.app import STATIC

    folder = tmp_path_factory.mktemp("web") / "static"
    shutil.copytree(STATIC, folder)
    # The server writes this module.
    table = {each.value: (each.colour, each.symbol) for each in Status}
    (folder / "statuses.js").write_text(f"export const STATUSES = {json.dumps(table)};")
    (folder / "package.json").write_text('{"type": "module"}')
    (folder / "drawn.js").write_text(DRAWN)
    return folder / "drawn.js"


def marks(script, **times):
    """Marks of one finding with these times, by the name of their lane."""
    finding = Finding("motor-angle", Status.FAULT, "The angle sensor differs.", **times)
    findings = json.loads(to_json(Diagnosis(findings=(finding,))))["findings"]
    result = {"monitors": {"motor-angle": {"findings": findings, "decisions": [], "elements": []}}}
    done = subprocess.run(["node", script], input=json.dumps(result), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return {lane["name"]: lane["marks"] for lane in json.loads(done.stdout)}


def test_a_fault_that_ended_is_drawn_to_its_end_and_one_that_lasts_to_the_end_of_the_recording(script):
    (ended,) = marks(script, since=6.2, end=6.75)["motor-angle"]
    assert (ended["from"], ended["to"]) == (6.2, 6.75)
    assert "from" in ended["text"]
    assert "since" not in ended["text"]
    (lasts,) = marks(script, since=6.2)["motor-angle"]
    assert (lasts["from"], lasts["to"]) == (6.2, 60)
    assert "since" in lasts["text"]


def test_the_declaration_is_drawn_where_it_is_known(script):
    drawn = marks(script, since=6.2, declared=7.13)
    (declared,) = drawn["motor-angle: decisions"]
    assert declared["from"] == 7.13
    assert declared["title"].startswith("declared at")
    assert list(marks(script, since=6.2)) == ["motor-angle"]
