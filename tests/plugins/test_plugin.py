"""A plug-in package is built, unpacked as pip does, and used by commands and by Python as tierod's own."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tierod.io.readers import read

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "examples" / "tierod-wheel-imbalance"

DRIVE = """
import numpy as np, tierod
time = np.arange(6000) / 100.0
speed = 25.0 + 3.0 * np.sin(0.3 * time)
shaking = 0.3 * np.cos(np.cumsum(speed) / 100.0 / 0.3) + np.random.default_rng(1).normal(0.0, 0.2, 6000)
channels = [tierod.Channel("driver_torque", time, shaking, "N*m"), tierod.Channel("vehicle_speed", time, speed, "m/s")]
drive = tierod.Recording({each.name: each for each in channels})
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plugin")
    shutil.copytree(SOURCE, folder / "source", ignore=shutil.ignore_patterns("build", "*.egg-info"))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    built = folder / "built"
    offline = ["--no-deps", "--no-build-isolation", "--no-index"]
    run([*pip, "wheel", *offline, "-w", built, folder / "source"], folder)
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(command, folder, *more, code=0):
    """Run a command in a folder, with further folders for Python to look into; its stdout and stderr."""
    paths = os.pathsep.join(map(str, [*more, ROOT / "packages/tierod/src"]))
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run([*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stdout, done.stderr


def tierod(folder, *arguments, site, code=0):
    sites = [site] if isinstance(site, Path) else site
    return run([sys.executable, "-m", "tierod", *arguments], folder, *sites, code=code)


SEVERAL = """
import contextlib, io, json, sys
from tierod.cli import main
for words in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = main(words)
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""


def several(folder, commands, *sites):
    """(exit code, stdout, stderr) of each of some commands, which are run by one process after one another."""
    lines = run([sys.executable, "-c", SEVERAL, json.dumps(commands)], folder, *sites)[0].splitlines()
    return [json.loads(line) for line in lines]


def python(folder, text, *sites, code=0):
    return run([sys.executable, "-c", text], folder, *sites, code=code)


def package(folder, name, group, point, value, text=""):
    """A package as pip leaves it behind: a module and its metadata."""
    about = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text(f"[{group}]\n{point} = {value}\n", encoding="utf-8")
    (folder / f"{value.partition(':')[0].partition('.')[0]}.py").write_text(text, encoding="utf-8")
    return folder


def test_every_part_of_the_sample_is_used(installed, tmp_path):
    python(tmp_path, f"{DRIVE}\ntierod.write(drive, 'drive.wim')", installed)
    assert (tmp_path / "drive.wim").read_text(encoding="utf-8").startswith("WIM 1\n")
    result = tierod(
        tmp_path, "diagnose", "drive.wim", "--vehicle", "balancing-car", "--json", "--memory", "m.json", site=installed,
        code=1,
    )[0]  # fmt: skip
    finding = json.loads(result)["findings"][0]
    assert finding["monitor"] == "wheel-imbalance"
    assert finding["status"] == "fault"
    assert finding["estimate"]["value"] == pytest.approx(0.3, abs=0.05)
    assert (tmp_path / "drive-wheel-imbalance.html").is_file()
    commands = ["monitors --json", "monitors wheel-imbalance", "formats --json", "inspect drive.wim --json",
                "diagnose drive.wim --vehicle balancing-car --monitor wheel-imbalance --no-report"]  # fmt: skip
    done = several(tmp_path, [each.split() for each in commands], installed)
    assert [code for code, *_ in done] == [0, 0, 0, 0, 1], done
    listed, shown, formats, inspected = [out for _, out, _ in done[:4]]
    packages = {each["name"]: each["package"] for each in json.loads(listed)["monitors"]}
    assert packages["wheel-imbalance"] == "tierod-wheel-imbalance 0.1.0"
    assert packages["friction"] == "tierod"
    assert "Package: tierod-wheel-imbalance 0.1.0" in shown
    inspected = json.loads(inspected)
    assert inspected["metadata"]["format"] == "WIM"
    assert {each["name"]: each["can_run"] for each in inspected["monitors"]}["wheel-imbalance"]
    formats = json.loads(formats)
    assert ["wim", "WIM (.wim)", "tierod-wheel-imbalance 0.1.0"] in [[*each.values()] for each in formats["read"]]
    assert formats["written"][-1]["ending"] == ".wim"


def test_vehicle_fault_and_scenario_stand_in_the_lists(installed, tmp_path):
    kinds = (("vehicles", "balancing-car"), ("faults", "shaken-torque"), ("scenarios", "motorway-shaken"))
    commands = [words for kind, name in kinds for words in ([kind], [kind, name])]
    simulation = ["simulate", "motorway-shaken", "-o", "drive.parquet", "--seconds", "5"]
    *shown, (simulated, *_) = several(tmp_path, [*commands, simulation], installed)
    assert simulated == 0
    for words, (code, out, _) in zip(commands, shown, strict=True):
        assert code == 0
        assert dict(kinds)[words[0]] in out
    assert "driver_torque" in read(tmp_path / "drive.parquet").names


BROKEN = (
    ("import no_such_library", "cannot be imported (ModuleNotFoundError: No module"),
    ("", "cannot be imported (AttributeError"),
    ("raise SystemExit('stop')", "cannot be imported (SystemExit: stop)"),
    ("MONITOR = object()", "is of the type 'object'; expected a tierod.Monitor"),
    (
        "from tierod import Monitor\nMONITOR = Monitor('broken-4', '', '', '', (), (), 1.0, 1.0, 1.0, {}, None)",
        "has no variant",
    ),
    (
        "from tierod import Monitor, Variant\n"
        "MONITOR = Monitor('other', '', '', '', (), (), 1.0, 1.0, 1.0, {'a': Variant('a', '', '', print)}, 'a')",
        "calls itself 'other'",
    ),
)
"""Texts of modules that should hold a monitor, and what is said of each."""


def test_broken_monitors_are_named_with_their_package_and_all_else_goes_on(tmp_path):
    site = tmp_path / "site"
    for number, (text, _) in enumerate(BROKEN):
        value = f"broken{number}:MONITOR"
        package(site, f"broken-package-{number}", "tierod.monitors", f"broken-{number}", value, text)
    names = ["monitors --json", *(f"monitors broken-{number}" for number in range(len(BROKEN))), "monitors friction"]
    listed, *each, friction = several(tmp_path, [name.split() for name in names], site)
    assert "friction" in {monitor["name"] for monitor in json.loads(listed[1])["monitors"]}
    assert sorted(listed[2].splitlines()) == listed[2].splitlines()
    for number, (line, (code, _, said)) in enumerate(zip(listed[2].splitlines(), each, strict=True)):
        sentence = BROKEN[number][1]
        begin = f"tierod: the monitor 'broken-{number}' of the package broken-package-{number} 1.0 "
        assert line.startswith(begin)
        assert sentence in line
        assert f"pip uninstall broken-package-{number}" in line
        assert code == 3
        assert sentence in said
        assert said.count("\n") == 1
    assert friction[0] == 0
    assert friction[2] == ""


READER = "from tierod.io.readers import Format\nREADER = Format('odd', 'odd', ('.odd',), {open}, {recognises})"


@pytest.mark.parametrize(
    ("open_", "recognises", "code", "sentence"),
    [
        ("lambda content, time: 1 / 0", "lambda head, ending: head.startswith(b'ODD')", 3,
         "drive.odd cannot be read by the reader 'odd' of the package odd-reader 1.0 (ZeroDivisionError"),
        ("print", "lambda head, ending: 1 / 0", 0,
         "the reader 'odd' of the package odd-reader 1.0 fails to look at a file (ZeroDivisionError"),
    ],
)  # fmt: skip
def test_a_reader_that_fails_is_named(tmp_path, open_, recognises, code, sentence):
    text = READER.format(open=open_, recognises=recognises)
    site = package(tmp_path / "site", "odd-reader", "tierod.readers", "odd", "odd:READER", text)
    rows = "".join(f"{step / 10.0},{step % 3}\n" for step in range(20))
    (tmp_path / "drive.odd").write_text(
        ("ODD\n" if code else "") + "time [s],driver_torque [N*m]\n" + rows, encoding="utf-8"
    )
    said = tierod(tmp_path, "inspect", "drive.odd", site=site, code=code)[1]
    assert sentence in said
