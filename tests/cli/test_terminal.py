import json
import math
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from tierod.cli import terminal
from tierod.cli.app import run
from tierod.cli.terminal import print_json, progress


def test_numbers_that_json_cannot_hold_become_null(capsys):
    print_json({"a": math.nan, "b": [1.5, -math.inf, ("x", None)]})
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": [1.5, None, ["x", None]]}


class Clock:
    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now


@pytest.mark.parametrize(("seconds", "shown"), [(0.5, False), (1.5, True)])
def test_progress_appears_after_a_second_and_never_on_stdout(monkeypatch, capsys, seconds, shown):
    clock = Clock()
    monkeypatch.setattr(terminal, "time", clock)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with progress("reading") as advance:
        advance(0.1)
        clock.now = seconds
        advance(0.9)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert ("reading" in captured.err) is shown


EVIL = "\x1b[31m\x1b]0;owned\x07\x9b2J\x7f\x85\u202eevil\u2066[bold]x[/bold][/nothing][link=http://a]\u2028"
STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


@pytest.fixture
def evil_drive(tmp_path):
    """A recording with an evil column, name, unit and text, read as a Parquet file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    time = 0.01 * np.arange(500)
    columns = {"time": time, EVIL: time}
    fields = [pa.field(name, pa.float64(), metadata={"unit": EVIL if name == EVIL else ""}) for name in columns]
    folder = tmp_path / "a\x1b[31m\u202eb"
    folder.mkdir()
    pq.write_table(pa.table(list(columns.values()), schema=pa.schema(fields)), folder / "evil_drive.parquet")
    return folder / "evil_drive.parquet"


@pytest.mark.parametrize("arguments", [["inspect", "--all"], ["inspect", "--all", "--json"], ["diagnose"]])
def test_no_command_lets_names_steer_the_terminal(evil_drive, capsys, arguments):
    refused = arguments[0] == "diagnose"
    code = run([*arguments, str(evil_drive.with_name("absent.csv") if refused else evil_drive)])
    printed = capsys.readouterr()
    assert code == (3 if refused else 0)
    assert "u202e" in printed.err if refused else "evil" in printed.out
    assert not STEERING.search(printed.out + printed.err)
    if "--json" in arguments:
        assert EVIL in [row["name"] for row in json.loads(printed.out)["channels"]]


@pytest.mark.parametrize(
    ("name", "content"), [("vehicle", 'name = "a"\n"{}" = 1\n'), ("map", '[signals."{}"]\nsource = "a"\n')]
)
def test_no_error_lets_a_file_steer_the_terminal(evil_drive, tmp_path, capsys, name, content):
    file = tmp_path / "a.toml"
    file.write_text(content.format("\\u001b[31m\u202e\u009b"), encoding="utf-8")
    assert run(["inspect", str(evil_drive), f"--{name}", str(file)]) == 3
    printed = capsys.readouterr().err
    assert "\\u001b" in printed
    assert not STEERING.search(printed)


@pytest.mark.parametrize(
    ("encoding", "options"),
    [("ascii", []), pytest.param("ascii", ["--json"], marks=pytest.mark.slow), ("cp437", ["--json"])],
)
def test_any_encoding_of_the_output_will_do(evil_drive, encoding, options):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "tierod", "inspect", "--all", str(evil_drive), *options]
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert (done.returncode, b"evil" in done.stdout) == (0, True), done.stderr
    if options:
        names = [row["name"] for row in json.loads(done.stdout.decode(encoding))["channels"]]
        assert EVIL in names
