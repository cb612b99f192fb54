"""Every option that takes a file refuses what is no such file in one sentence, at once, without waiting."""

import os
import shlex
import signal
from pathlib import Path

import numpy as np
import pytest

from tierod.cli.app import run
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write

EPS = "--no-report --vehicle midsize-eps"
TEXTS = (
    "vehicles FILE.toml", "vehicles FILE.toml --toml", "scenarios FILE.toml", "scenarios FILE.toml --toml",
    "scenarios FILE.toml --cars", "scenarios FILE.csv --courses", "simulate FILE.toml -o made.csv", "faults FILE.toml",
    "faults FILE.toml --toml", "faults read FILE.json", "faults snapshot FILE.json friction",
    "campaign FILE.toml --dry-run", "campaign FILE.toml --toml", "inspect DRIVE --map FILE.toml",
    "inspect LOG --dbc FILE.dbc", "diagnose DRIVE --no-report --vehicle FILE.toml",
    f"diagnose DRIVE {EPS} --map FILE.toml", f"diagnose DRIVE {EPS} --baseline FILE.json",
    f"diagnose DRIVE {EPS} --memory FILE.json", "isolability --no-report --vehicle FILE.toml",
    "identify column DRIVE --vehicle FILE.toml", "identify column DRIVE --vehicle column-bench --map FILE.toml",
)  # fmt: skip
RECORDINGS = (
    "inspect FILE.csv", "diagnose FILE.csv --no-report", "identify column FILE.csv --vehicle column-bench",
    "design detector --shift 1 --rate 100 --residual FILE.csv --false-alarms '1 per h'",
)  # fmt: skip


def binary(path):
    path.write_bytes(bytes(np.random.default_rng(1).integers(0, 256, 5000, np.uint8)))


def large(path):
    with path.open("wb") as file:
        file.truncate(100 << 20)


def deep(path):
    path.write_text(1000 * "[" if path.suffix == ".json" else "a = " + 1000 * "[")


KINDS = {
    "missing": lambda path: None,
    "folder": Path.mkdir,
    "fifo": os.mkfifo,
    "loop": lambda path: path.symlink_to(path),
    "zeros": lambda path: path.symlink_to("/dev/zero"),
    "nothing": lambda path: path.symlink_to("/dev/null"),
    "empty": Path.touch,
    "binary": binary,
    "large": large,
    "deep": deep,
    "dotted": lambda path: path.write_text("a" + 50_000 * ".a" + " = 1\n"),
}


@pytest.fixture(autouse=True)
def impatient():
    """A command that waits for ever ends with an error that shows where."""

    def stop(number, frame):
        raise AssertionError(f"the command hangs: {frame}")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """A drive that a monitor accepts, and a CAN log."""
    here, time = tmp_path_factory.mktemp("samples"), 0.01 * np.arange(1000)
    names = {"steering_wheel_angle": "rad", "steering_wheel_rate": "rad/s", "vehicle_speed": "m/s"}
    names |= {"driver_torque": "N*m", "motor_torque": "N*m", "yaw_rate": "rad/s", "lateral_acceleration": "m/s**2"}
    channels = {name: Channel(name, time, np.sin(time + len(name)), unit) for name, unit in names.items()}
    write(Recording(channels), here / "drive.csv")
    (here / "can.log").write_text("".join(f"({0.01 * k:.6f}) can0 123#0102\n" for k in range(100)))
    return {"DRIVE": here / "drive.csv", "LOG": here / "can.log"}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", [*TEXTS, *RECORDINGS])
def test_a_file_that_is_none_is_refused_in_a_sentence(command, kind, samples, tmp_path, capsys, monkeypatch):
    if kind == "missing" and ("--baseline" in command or "--memory" in command):
        pytest.skip("it is begun where it is missing")
    if kind == "empty" and command == "scenarios FILE.toml --toml":
        pytest.skip("the file is printed as it is")
    if kind == "fifo" and command in RECORDINGS:
        pytest.skip("a recording may come through a pipe")
    monkeypatch.chdir(tmp_path)
    given = [str(samples.get(word, word)) for word in shlex.split(command)]
    (place,) = (place for place, word in enumerate(given) if word.startswith("FILE"))
    given[place] = given[place].replace("FILE", "given")
    KINDS[kind](Path(given[place]))
    code = run(given)
    said = capsys.readouterr().err
    assert code == 3, said
    last = said.strip().splitlines()[-1]
    assert last.startswith("tierod: ")
    assert "given" in last or command in RECORDINGS
    assert "defect" not in said
