"""The command that a simulation prints is run, and judges what the scenario is made for; some have none."""

import shlex

import pytest

from tierod.cli import main
from tierod_lab.ground.scenarios import load, shipped

LONG = ("country-drive-friction-ramp", "demonstrator-healthy", "mixed-drive-friction-step", "mixed-drive-healthy",
        "worn-sensors-in-town", "hot-motor-in-town", "active-front-steering-drive", "column-bench-locked-sweep",
        "column-bench-ramps", "column-bench-sweep", "motor-bench-multisine", "parking-large-car", "demonstrator-lap",
        "column-bench-hands", "steer-by-wire-sideslip")  # fmt: skip
"""Scenarios that take long to drive or to judge; others lead to the same monitors, or pages of the documentation run
the same commands."""

CASES = [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in shipped()]

SECONDS = {"column-bench-hands": "20", "motor-bench-sweep": "10"}
"""Of scenarios that need not be driven to their end to be judged."""

FIRST_IS_THE_REFERENCE = "lock-to-lock-on-ground"
"""Tyres scrub on the ground: a car is judged there from its second test on."""


def printed(capsys, name):
    """The command that a simulation of a shipped scenario prints in the end."""
    limit = ["--seconds", SECONDS[name]] if name in SECONDS else []
    assert main(["simulate", name, "-o", "drive.parquet", *limit]) == 0
    lines = capsys.readouterr().out.splitlines()
    (command,) = [line.removeprefix("go on with: ") for line in lines if line.startswith("go on with: ")]
    words = shlex.split(command)
    assert words[0] == "tierod"
    return words[1:]


@pytest.mark.parametrize("name", CASES)
def test_the_next_command_ends_in_a_judgement_where_there_is_one(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    if not load(name).vehicle:
        assert main(["simulate", name, "-o", "drive.parquet", "--seconds", "1"]) == 0
        assert "go on with" not in capsys.readouterr().out
        return
    words = printed(capsys, name)
    code = main(words)
    if name == FIRST_IS_THE_REFERENCE:
        assert code == 2
        assert "NOT TESTABLE" in capsys.readouterr().out
        code = main(words)
    captured = capsys.readouterr()
    assert code in (0, 1), captured.out + captured.err
    assert "NOT ENABLED" not in captured.out
