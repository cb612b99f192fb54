"""Every monitor on recordings as cars give them: no truth, foreign column names, units of the workshop, any format."""

import json
import math

import pytest

from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.registry import MONITORS

FORMATS = ("csv", "parquet", "mf4")
FOREIGN = {
    "rad": ("deg", 180.0 / math.pi),
    "rad/s": ("deg/s", 180.0 / math.pi),
    "m/s": ("km/h", 3.6),
    "m/s**2": ("g", 1.0 / 9.80665),
    "N": ("kN", 1e-3),
    "A": ("mA", 1e3),
    "": ("%", 100.0),
}
"""Unit of the workshop for each unit of tierod, and how many of it make one; units that are missing stay."""

DRIVES = {
    "friction": ("mixed-drive-healthy", "120", "midsize-eps", ()),
    "hysteresis": ("lock-to-lock-on-hoist", None, "midsize-eps", ("--variant", "hoist")),
    "sideslip": ("steer-by-wire-sideslip", "15", "steer-by-wire", ()),
    "driver-torque": ("column-bench-hands", "20", "column-bench", ()),
    "motor-angle": ("motor-bench-sweep", "4", "motor-bench", ()),
    "condition": ("demonstrator-lap", "15", "smartload", ()),
}
"""For every monitor: scenario, duration [s], vehicle, further options."""


def as_a_car_gives_it(path, folder, ending):
    """(recording without truth and metadata under foreign names and units, the map that says what they are)."""
    channels, lines = {}, []
    known = [each for each in read(path).channels.values() if not each.name.startswith("truth_")]
    for place, channel in enumerate(known):
        name, (unit, factor) = f"Grp{place % 3}.x{place}_raw", FOREIGN.get(channel.unit, (channel.unit, 1.0))
        channels[name] = Channel(name, channel.time, factor * channel.values, unit)
        lines += [f"[signals.{channel.name}]", f'source = "{name}"', f'unit = "{unit}"', "optional = true"]
    target, channel_map = folder / f"foreign.{ending}", folder / "map.toml"
    write(Recording(channels), target)
    channel_map.write_text("\n".join(lines), encoding="utf-8")
    return target, channel_map


def document(capsys, arguments):
    """(exit code, JSON document) of a command."""
    capsys.readouterr()
    code = main([*arguments, "--json"])
    captured = capsys.readouterr()
    return code, json.loads(captured.out) if captured.out else captured.err


def alike(one, other):
    """Whether two JSON values are the same but for rounding, by which steps of a sensor may fall to either side."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=1e-3, abs_tol=1e-6)
    return one == other


def judged(finding):
    """What a finding says of the car, less what it says beside a truth and on where the signals came from."""
    evidence = {name: value for name, value in finding["evidence"].items() if "truth" not in name}
    found = {key: finding[key] for key in ("monitor", "status", "since", "estimate", "cause")} | {"evidence": evidence}
    # Only a truth can confirm the sideslip angle.
    confirmed = found["monitor"].startswith("sideslip") and evidence != finding["evidence"]
    return found | {"status": {"consistent": "estimated"}.get(found["status"], found["status"])} if confirmed else found


@pytest.mark.parametrize(
    ("monitor", "ending"), [(each, FORMATS[at % len(FORMATS)]) for at, each in enumerate(MONITORS)]
)
def test_a_verdict_needs_no_truth_and_no_names_of_ours(tmp_path, capsys, monitor, ending):
    if ending == "mf4":
        pytest.importorskip("asammdf")
    scenario, seconds, vehicle, more = DRIVES[monitor]
    ours = tmp_path / "ours.parquet"
    assert main(["simulate", scenario, "-o", str(ours), "--json", *(["--seconds", seconds] if seconds else [])]) == 0
    foreign, channel_map = as_a_car_gives_it(ours, tmp_path, ending)
    options = ["--monitor", monitor, "--vehicle", vehicle, *more, "--no-report", "--no-spread"]
    code, expected = document(capsys, ["diagnose", str(ours), *options])
    again, found = document(capsys, ["diagnose", str(foreign), *options, "--map", str(channel_map)])
    assert again == code < 3, found
    assert alike(judged(found["findings"][0]), judged(expected["findings"][0]))
    assert alike(
        [(each["name"], each["status"], each["episodes"]) for each in found["elements"]],
        [(each["name"], each["status"], each["episodes"]) for each in expected["elements"]],
    )
