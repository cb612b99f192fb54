"""`tierod simulate`: one run, whole or not at all."""

import contextlib
import errno
import json
import os

import numpy as np
import pytest

from tierod.cli import main
from tierod.io.readers import read
from tierod_lab.ground.scenarios import Scenario

TEXT = """\
name = "mine"
description = "Mine."
seconds = 8.0
course = "iso-7401-step"
[car]
name = "midsize-eps-light"
"""
FAULT = '[[faults]]\nelement = "yaw_rate"\nbehaviour = "offset"\nsize = "3 deg/s"\nstart = "4 s"\n'


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    """A function that writes a scenario into the working directory."""
    monkeypatch.chdir(tmp_path)

    def put(text=TEXT + FAULT):
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        return "mine.toml"

    return put


@pytest.mark.parametrize("ending", ["parquet", "csv", "mf4"])
def test_writes_measured_channels_beside_the_truth(scenario, capsys, ending):
    if ending == "mf4":
        pytest.importorskip("asammdf")
    assert main(["simulate", scenario(), "-o", f"drive.{ending}"]) == 0
    printed = capsys.readouterr().out
    assert "yaw_rate offset" in printed
    assert f"tierod inspect drive.{ending}" in printed
    assert f"tierod diagnose drive.{ending} --vehicle midsize-eps" in printed
    recording = read(f"drive.{ending}")
    measured, true = recording["yaw_rate"], recording["truth_yaw_rate"]
    late = measured.time >= 4.0
    error = measured.values - np.interp(measured.time, true.time, true.values)
    assert np.mean(error[late]) - np.mean(error[~late]) == pytest.approx(np.radians(3.0), abs=2e-3)
    assert recording.metadata["scenario_text"] == TEXT + FAULT
    assert recording.metadata["faults"][0]["start"] == 4.0
    assert recording.metadata["seed"] == 0


def test_shows_one_run_as_json(scenario, capsys):
    assert main(["simulate", scenario(), "-o", "a.parquet", "--seed", "5", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["schema"] == "tierod.simulation/1"
    assert (result["scenario"], result["seed"], result["seconds"]) == ("mine", 5, 8.0)
    assert result["diverged_at"] is None
    assert result["faults"] == [
        {"name": "yaw_rate offset", "element": "yaw_rate", "behaviour": "offset", "start": 4.0, "end": 8.0}
    ]
    assert "yaw_rate" in result["measured_channels"]
    assert "truth_yaw_rate" in result["truth_channels"]
    assert main(["simulate", scenario(), "-o", "b.parquet", "--seed", "5", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again | {"recording": ""} == result | {"recording": ""}
    with open("a.parquet", "rb") as first, open("b.parquet", "rb") as second:
        assert first.read() == second.read(), "the same run gives the same file, to the bit"


def test_another_duration_leaves_later_faults_out_and_says_so(scenario, capsys):
    assert main(["simulate", scenario(), "-o", "drive.csv", "--seconds", "2"]) == 0
    assert "left out, since it begins after the end of the run: yaw_rate offset" in capsys.readouterr().err
    assert read("drive.csv").span[1] < 2.0


def test_a_run_that_diverges_is_kept_up_to_there_and_could_not_be_judged(scenario, capsys):
    name = scenario(TEXT.replace("-light", "") + 'parameters.chassis.suspension_lag = "0.1 ms"')
    assert main(["simulate", name, "-o", "drive.parquet", "--json"]) == 2
    captured = capsys.readouterr()
    last = json.loads(captured.out)["diverged_at"]
    assert 0.0 < last < 8.0
    assert captured.err.count("\n") == 1
    assert f"the run diverged: its last good time is {last:g} s of 8 s" in captured.err
    recording = read("drive.parquet")
    assert recording.span[1] <= last
    assert recording.metadata["diverged_at"] == last


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["mine.toml"], "Missing option '--output'"),
        (["mine.toml", "-o", "drive.mp4"], "drive.mp4 has no ending that can be written; did you mean '.mf4'"),
        (["mine.toml", "-o", "absent/drive.csv"], "there is no folder absent; create it first"),
        (["mine.toml", "-o", "drive.csv", "--seconds", "-1"], "a run cannot last -1 s"),
        (["mine.toml", "-o", "drive.csv", "--seconds", "100"], "'iso-7401-step' ends after"),
        (["mine.toml", "-o", "drive.csv", "--seed", "-1"], "Invalid value for '--seed'"),
        (["step-stear", "-o", "drive.csv"], "no scenario is called 'step-stear'; did you mean 'step-steer'"),
    ],
)
def test_wrong_use_is_reported_before_anything_is_driven(scenario, monkeypatch, capsys, tmp_path, arguments, sentence):
    scenario()
    monkeypatch.setattr(Scenario, "run", lambda *_: pytest.fail("driven"))
    assert main(["simulate", *arguments]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert sentence in captured.err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


def test_a_slip_in_the_file_is_reported_with_its_line(scenario, capsys):
    assert main(["simulate", scenario(TEXT.replace("-light", "-lite")), "-o", "drive.csv"]) == 3
    message = capsys.readouterr().err
    assert "mine.toml, line 6: no virtual car is called 'midsize-eps-lite'; did you mean 'midsize-eps-light'" in message


def test_a_full_disk_leaves_nothing_half_written(scenario, monkeypatch, capsys, tmp_path):
    def full(*_args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (tmp_path / "drive.parquet").write_bytes(b"old")
    name = scenario()
    monkeypatch.setattr(os, "fsync", full)
    assert main(["simulate", name, "-o", "drive.parquet"]) == 3
    assert "no space left on device; make room on the disk or name another place" in capsys.readouterr().err
    assert (tmp_path / "drive.parquet").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.parquet", "mine.toml"]


@pytest.mark.parametrize("where", ["drive", "write"])
def test_ctrl_c_leaves_nothing_half_written(scenario, monkeypatch, capsys, tmp_path, where):
    def stop(*_args):
        raise KeyboardInterrupt

    name = scenario()
    if where == "drive":
        monkeypatch.setattr(Scenario, "run", stop)
    else:
        monkeypatch.setattr(os, "fsync", stop)
    assert main(["simulate", name, "-o", "drive.parquet"]) == 130
    assert "stopped; no incomplete file is left" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


def test_the_help_names_the_unit_of_the_duration(capsys):
    with contextlib.suppress(SystemExit):
        main(["simulate", "--help"])
    assert "in seconds" in " ".join(capsys.readouterr().out.replace("│", " ").split())
