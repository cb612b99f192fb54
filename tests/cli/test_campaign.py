"""What 'tierod campaign' prints, writes and ends with."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest

from experiments.test_campaign import BASE
from tierod.cli import main
from tierod_lab.campaign.summary import read_table

SCHEMA = json.loads(files("tierod_lab.campaign").joinpath("campaign.schema.json").read_text(encoding="utf-8"))
FILE = """name = "lost signals"
description = "Signals that are lost."
scenario = "base.toml"
seeds = [1, 2]

[faults.yaw-rate]
element = "yaw_rate"
behaviour = "total-loss"
start = "10 s"

[[monitors]]
monitor = "friction"
vehicle = "midsize-eps"
baseline = "none"
"""
GATE = '[[gates]]\nfigure = "{}"\ngoal = "{}"\n'


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("base.toml").write_text(BASE)
    Path("c.toml").write_text(FILE)
    return tmp_path


def campaign(*arguments):
    return main(["campaign", *map(str, arguments)])


@pytest.fixture(scope="module")
def run_once(tmp_path_factory):
    """A folder with a campaign that has run."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "base.toml").write_text(BASE)
    (folder / "c.toml").write_text(FILE)
    assert campaign(folder / "c.toml", "-o", folder / "runs", "--workers", 1) == 0
    return folder


@pytest.fixture
def ran(run_once, tmp_path, monkeypatch):
    shutil.copytree(run_once, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_campaign_leaves_recordings_verdicts_table_document_and_page(ran, capsys):
    runs = ran / "runs"
    for kind, count in (("drives", 4), ("recordings", 4), ("verdicts", 4)):
        assert len(list((runs / kind).iterdir())) == count
    assert [row.given for row in read_table(runs / "cells.parquet")] == [*2 * ["fault-free"], *2 * ["yaw-rate"]]
    page = (runs / "report.html").read_text(encoding="utf-8")
    for recording in (runs / "recordings").iterdir():
        assert f'href="recordings/{recording.name}"' in page
    jsonschema.validate(json.loads((runs / "campaign.json").read_text(encoding="utf-8")), SCHEMA)


def test_the_same_command_again_only_shows_what_is_there(ran, capsys):
    before = {path: path.stat().st_mtime_ns for path in (ran / "runs").glob("*/*")}
    assert campaign("c.toml", "-o", "runs") == 0
    captured = capsys.readouterr()
    assert "report: runs/report.html" in captured.out
    assert "lost signals: 4 of 4 drives" in captured.err
    assert before == {path: path.stat().st_mtime_ns for path in (ran / "runs").glob("*/*")}


@pytest.mark.parametrize(
    ("figure", "goal", "code"), [("false_alarms", "= 0", 0), ("enabled_share", ">= 0.99", 1), ("area", ">= 0.9", 2)]
)
def test_gates_decide_the_exit_code_and_drive_nothing_anew(ran, figure, goal, code, capsys):
    Path("c.toml").write_text(FILE + GATE.format(figure, goal))
    assert campaign("c.toml", "-o", "runs") == code
    captured = capsys.readouterr()
    assert figure in captured.out
    assert "4 of 4 drives" in captured.err.splitlines()[0]


def test_a_dry_run_shows_matrix_and_cost_and_writes_nothing(place, capsys):
    assert campaign("c.toml", "-o", "runs", "--dry-run") == 0
    result = capsys.readouterr().out
    assert "4 drives, 0.0 h of driving" in result
    assert result.count("yaw-rate") == 2
    assert not (place / "runs").exists()
    assert campaign("c.toml", "-o", "runs", "--dry-run", "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert (len(content["drives"]), content["missing"], content["hours"]) == (4, 4, pytest.approx(80.0 / 3600.0))
    assert content["bytes"] > 1e5


def test_two_campaigns_are_compared(ran, capsys):
    Path("other.toml").write_text(FILE.replace('monitor = "friction"', 'monitor = "friction"\nvariant = "refined"'))
    assert campaign("other.toml", "-o", "others", "--workers", 1) == 0
    capsys.readouterr()
    assert campaign("--compare", "runs", "others", "-o", "compared") == 0
    result = capsys.readouterr().out
    assert "friction, pre-sliding against friction, refined: 0 verdicts of 4 changed" in result
    assert json.loads(Path("compared/comparison.json").read_text())["schema"] == "tierod.comparison/1"
    assert Path("compared/comparison.html").read_text().startswith("<!doctype html>")
    assert campaign("--compare", "runs", "nothing", "-o", "compared", "--json") == 3
    assert campaign("c.toml", "--compare", "runs", "others") == 3


def test_shipped_campaigns_are_listed_and_printed(capsys):
    assert campaign() == 0
    result = capsys.readouterr().out
    name = result.splitlines()[1].split()[0]
    assert campaign(name, "--toml") == 0
    assert capsys.readouterr().out.startswith("name = ")


def test_a_campaign_that_is_stopped_says_how_to_go_on_and_leaves_no_process(place):
    Path("c.toml").write_text(FILE.replace("[1, 2]", "{ first = 1, count = 50 }"))
    command = [sys.executable, "-m", "tierod", "campaign", "c.toml", "-o", "runs", "--workers", "1"]
    heard = partial(
        signal.signal, signal.SIGINT, signal.SIG_DFL
    )  # a shell lets what it starts in the background ignore SIGINT
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heard)
    deadline = time.monotonic() + 120.0
    while not list(place.glob("runs/verdicts/*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, result = process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert "of 100 drives are finished and kept in runs; the same command goes on from there" in result
    # Python's own tracker of resources ends a moment after the process that it serves.
    while alive(process.pid):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
