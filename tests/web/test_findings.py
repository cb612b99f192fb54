"""Marks of findings on the time axis of the workbench, as its own script makes them."""

import json
import shutil
import subprocess

import pytest

from tierod.core.findings import Diagnosis, Finding, Status
from tierod.report import to_json

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
