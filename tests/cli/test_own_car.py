"""From a raw CSV file with foreign titles and a brochure to the report: each command is named by the one before."""

import shlex

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.recording import Recording
from tierod.io.readers import read
from tierod.vehicles import load
from tierod_lab.ground import drive

BROCHURE = ("mass=1.6 t", "wheelbase=2.83")

MOST = 6
"""Commands from the raw file to the report."""

TITLES = {
    "steering_wheel_angle": ("Lenkradwinkel", np.pi / 180.0),
    "driver_torque": ("Handmoment", 1.0),
    "motor_torque": ("EPS_Motormoment", 1.0),
    "vehicle_speed": ("Fahrzeuggeschwindigkeit", 1.0 / 3.6),
    "yaw_rate": ("Gierrate", -np.pi / 180.0),
    "lateral_acceleration": ("Querbeschleunigung", 1.0),
}
"""German titles, and the SI value of one unit of the column: the yaw rate counts right as positive."""


@pytest.fixture(scope="module")
def recording() -> Recording:
    return drive(minutes=3.0, seed=5)


def raw_file(recording, path):
    """The recording as another logger would have written it."""
    names = [name for name in TITLES if name in recording]
    aligned = recording.align(names, 100.0, maximum_age=0.1)
    table = aligned.values / np.array([TITLES[name][1] for name in names])
    header = ",".join(["Zeit", *(TITLES[name][0] for name in names), "Kilometerstand"])
    columns = np.column_stack([aligned.time, table, np.full(len(aligned.time), 4711.0)])
    np.savetxt(path, columns, delimiter=",", header=header, comments="", fmt="%.6f")
    return names


def next_command(printed):
    """The words of the command that goes on; the one that judges at once where there is a choice."""
    lines = [line for line in printed.splitlines() if line.startswith(("go on with: ", "or judge at once: "))]
    return shlex.split(lines[-1].partition(": ")[2])[1:] if lines else None


def test_six_commands_are_enough(recording, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = raw_file(recording, "fahrt vom montag.csv")
    words = ["inspect", "fahrt vom montag.csv", "--write-map", "car.channels.toml"]
    ran = []
    while words is not None and len(ran) < MOST:
        if words[0] == "new":
            words = [*words, *BROCHURE]
        code = main(words)
        captured = capsys.readouterr()
        assert code in (0, 1, 2), captured.err
        ran.append(words[0])
        words = next_command(captured.out)
    assert ran[0] == "inspect"
    assert ran[-1] == "diagnose"
    assert "report: " in captured.out
    (page,) = tmp_path.glob("*.html")
    assert "friction" in page.read_text(encoding="utf-8")
    found = read("fahrt vom montag.csv", channel_map=load("car.toml").channel_map, names=names)
    reference = recording.align(names, 100.0, maximum_age=0.1)
    for name, values in zip(names, reference.values.T, strict=True):
        good = np.isfinite(values)
        assert found[name].values[: len(good)][good] == pytest.approx(values[good], abs=1e-4), name
