"""Nothing in a user's file steers the terminal, and no encoding of the output is an error."""

import io
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from tierod.cli.app import run
from tierod.cli.terminal import console, spell_what_cannot_be_shown, visible

EVIL = "\x1b[31m\x1b]0;owned\x07\x9b2J\x7f\x85\u202eevil\u2066[bold]x[/bold][/nothing][link=http://a]\u2028"
STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


@pytest.fixture
def drive(tmp_path):
    """A recording with an evil column, name, unit and text, read as a Parquet file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    time = 0.01 * np.arange(500)
    columns = {"time": time, EVIL: time}
    fields = [pa.field(name, pa.float64(), metadata={"unit": EVIL if name == EVIL else ""}) for name in columns]
    folder = tmp_path / "a\x1b[31m\u202eb"
    folder.mkdir()
    pq.write_table(pa.table(list(columns.values()), schema=pa.schema(fields)), folder / "drive.parquet")
    return folder / "drive.parquet"


def test_text_that_steers_is_spelt_out():
    assert visible("a\tb\n°é\x1b[0m\u202e\ud800") == "a\tb\n°é\\u001b[0m\\u202e\\ud800"
    assert not STEERING.search(visible(EVIL))
    assert json.loads(f'"{visible(chr(27) + chr(0x9B))}"') == "\x1b\x9b"


def test_a_console_steers_its_terminal_and_texts_do_not(monkeypatch):
    from rich.table import Table
    from rich.text import Text

    monkeypatch.setattr(sys, "stdout", io.StringIO())
    shown = console(stderr=False, width=200)
    shown._force_terminal, shown._color_system = True, shown._detect_color_system() or None
    table = Table(title=Text(EVIL))
    table.add_column(Text(EVIL))
    table.add_row(Text(EVIL, style="bold"))
    shown.print(table)
    shown.print(EVIL, markup=False)
    text = re.sub(r"\x1b\[[0-9;]*m", "", sys.stdout.getvalue()) if shown._color_system else sys.stdout.getvalue()
    assert "evil" in text
    assert not STEERING.search(text)


@pytest.mark.parametrize("arguments", [["inspect", "--all"], ["inspect", "--all", "--json"], ["diagnose"]])
def test_no_command_lets_names_steer_the_terminal(drive, capsys, arguments):
    refused = arguments[0] == "diagnose"
    code = run([*arguments, str(drive.with_name("absent.csv") if refused else drive)])
    printed = capsys.readouterr()
    assert code == (3 if refused else 0)
    assert "u202e" in printed.err if refused else "evil" in printed.out
    assert not STEERING.search(printed.out + printed.err)
    if "--json" in arguments:
        assert EVIL in [row["name"] for row in json.loads(printed.out)["channels"]]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("vehicle", 'name = "a"\n"{}" = 1\n'),
        ("map", '[signals."{}"]\nsource = "a"\n'),
    ],
)
def test_no_error_lets_a_file_steer_the_terminal(drive, tmp_path, capsys, name, content):
    file = tmp_path / "a.toml"
    file.write_text(content.format("\\u001b[31m\u202e\u009b"), encoding="utf-8")
    assert run(["inspect", str(drive), f"--{name}", str(file)]) == 3
    printed = capsys.readouterr().err
    assert "\\u001b" in printed
    assert not STEERING.search(printed)


def test_an_error_message_has_a_length_that_can_be_read(tmp_path, capsys):
    (tmp_path / "a.toml").write_text(f'name = "a"\n{"a" * 500_000} = 1\n')
    assert run(["vehicles", str(tmp_path / "a.toml")]) == 3
    assert len(capsys.readouterr().err) < 2100


@pytest.mark.parametrize(
    ("encoding", "options"),
    [("ascii", []), pytest.param("ascii", ["--json"], marks=pytest.mark.slow), ("cp437", ["--json"])],
)
def test_any_encoding_of_the_output_will_do(drive, encoding, options):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "tierod", "inspect", "--all", str(drive), *options]
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert (done.returncode, b"evil" in done.stdout) == (0, True), done.stderr
    if options:
        names = [row["name"] for row in json.loads(done.stdout.decode(encoding))["channels"]]
        assert EVIL in names


def test_an_error_in_letters_that_the_output_lacks_is_printed(tmp_path):
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    path = os.fsencode(tmp_path) + b"/caf\xe9-\xf0\x9f\x9a\x97.toml"
    command = [sys.executable, "-m", "tierod", "vehicles", path]
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert done.returncode == 3
    assert rb"caf\udce9-\ud83d\ude97.toml" in done.stderr


def test_a_stream_that_spells_out_stays_one(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii"))
    spell_what_cannot_be_shown()
    print("N·m 🚗 \ud800")
    sys.stdout.flush()
    assert raw.getvalue() == b"N\\u00b7m \\ud83d\\ude97 \\ud800\n"
