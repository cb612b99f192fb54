"""Every option that takes a file refuses what is no such file in one sentence, at once, without waiting."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest

from tierod.cli.app import run
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write

PATIENCE = 20
"""Seconds after which a command hangs."""

TEXTS = {
    "vehicles": ["vehicles", "FILE.toml"],
    "vehicles --toml": ["vehicles", "FILE.toml", "--toml"],
    "scenarios": ["scenarios", "FILE.toml"],
    "scenarios --toml": ["scenarios", "FILE.toml", "--toml"],
    "scenarios --cars": ["scenarios", "FILE.toml", "--cars"],
    "scenarios --courses": ["scenarios", "FILE.toml", "--courses"],
    "scenarios --courses, a table": ["scenarios", "FILE.csv", "--courses"],
    "simulate": ["simulate", "FILE.toml", "-o", "HERE/made.csv"],
    "faults": ["faults", "FILE.toml"],
    "faults --toml": ["faults", "FILE.toml", "--toml"],
    "faults read": ["faults", "read", "FILE.json"],
    "faults snapshot": ["faults", "snapshot", "FILE.json", "friction"],
    "campaign": ["campaign", "FILE.toml", "--dry-run"],
    "campaign --toml": ["campaign", "FILE.toml", "--toml"],
    "inspect --map": ["inspect", "DRIVE", "--map", "FILE.toml"],
    "inspect --vehicle": ["inspect", "DRIVE", "--vehicle", "FILE.toml"],
    "inspect --dbc": ["inspect", "LOG", "--dbc", "FILE.dbc"],
    "diagnose --vehicle": ["diagnose", "DRIVE", "--no-report", "--vehicle", "FILE.toml"],
    "diagnose --map": ["diagnose", "DRIVE", "--no-report", "--vehicle", "midsize-eps", "--map", "FILE.toml"],
    "diagnose --baseline": [
        "diagnose",
        "DRIVE",
        "--no-report",
        "--vehicle",
        "midsize-eps",
        "--baseline",
        "FILE.json",
    ],
    "diagnose --memory": ["diagnose", "DRIVE", "--no-report", "--vehicle", "midsize-eps", "--memory", "FILE.json"],
    "isolability": ["isolability", "--no-report", "--vehicle", "FILE.toml"],
    "identify": ["identify", "column", "DRIVE", "--vehicle", "FILE.toml"],
    "identify --map": ["identify", "column", "DRIVE", "--vehicle", "column-bench", "--map", "FILE.toml"],
}
RECORDINGS = {
    "inspect": ["inspect", "FILE.csv"],
    "diagnose": ["diagnose", "FILE.csv", "--no-report"],
    "identify": ["identify", "column", "FILE.csv", "--vehicle", "column-bench"],
    "design": [
        "design",
        "detector",
        "--shift",
        "1",
        "--rate",
        "100",
        "--residual",
        "FILE.csv",
        "--false-alarms",
        "1 per h",
    ],
}
LEARNS = ("diagnose --baseline", "diagnose --memory")
"""Options whose file need not be there."""


def missing(path):
    return path


def folder(path):
    path.mkdir()
    return path


def fifo(path):
    os.mkfifo(path)
    return path


def zeros(path):
    path.symlink_to("/dev/zero")
    return path


def nothing(path):
    path.symlink_to("/dev/null")
    return path


def empty(path):
    path.touch()
    return path


def binary(path):
    path.write_bytes(bytes(np.random.default_rng(1).integers(0, 256, 5000, np.uint8)))
    return path


def large(path):
    with path.open("wb") as file:
        file.truncate(100 << 20)
    return path


def deep(path):
    path.write_text(1000 * "[" if path.suffix == ".json" else "a = " + 1000 * "[")
    return path


def dotted(path):
    path.write_text("a" + 50_000 * ".a" + " = 1\n")
    return path


KINDS = (missing, folder, fifo, zeros, nothing, empty, binary, large, deep, dotted)


@pytest.fixture(autouse=True)
def impatient():
    """A command that waits for ever ends with an error that shows where."""

    def stop(number, frame):
        raise AssertionError(f"the command hangs: {frame}")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(PATIENCE)
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


def refusal(arguments, kind, samples, here, capsys):
    """(exit code, what was printed to stderr)."""
    paths = samples | {"HERE": here}
    given = []
    for argument in arguments:
        if argument.startswith("FILE"):
            argument = str(kind(here / f"given{Path(argument).suffix}"))
        for name, path in paths.items():
            argument = argument.replace(name, str(path))
        given.append(argument)
    code = run(given)
    return code, capsys.readouterr().err


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("command", TEXTS)
def test_a_file_that_is_none_is_refused_in_a_sentence(command, kind, samples, tmp_path, capsys, monkeypatch):
    if kind is missing and command in LEARNS:
        pytest.skip("it is begun where it is missing")
    if kind is empty and command == "scenarios --toml":
        pytest.skip("the file is printed as it is")
    monkeypatch.chdir(tmp_path)
    code, sentence = refusal(TEXTS[command], kind, samples, tmp_path, capsys)
    assert code == 3, sentence
    last = sentence.strip().splitlines()[-1]
    assert last.startswith("tierod: ")
    assert "given" in last
    assert "defect" not in last


@pytest.mark.parametrize("kind", [each for each in KINDS if each is not fifo], ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("command", RECORDINGS)
def test_a_recording_that_is_none_is_refused_in_a_sentence(command, kind, samples, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, sentence = refusal(RECORDINGS[command], kind, samples, tmp_path, capsys)
    assert code == 3, sentence
    assert sentence.strip().splitlines()[-1].startswith("tierod: ")
    assert "defect" not in sentence
