"""A plug-in package is built, installed into a folder, and used by commands and by Python as tierod's own."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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
    """The folder that the sample plug-in is installed into."""
    folder = tmp_path_factory.mktemp("plugin")
    shutil.copytree(SOURCE, folder / "source", ignore=shutil.ignore_patterns("build", "*.egg-info"))
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    built = folder / "built"
    offline = ["--no-deps", "--no-build-isolation", "--no-index"]
    run([*pip, "wheel", *offline, "-w", built, folder / "source"], folder)
    run([*pip, "install", "--no-deps", "--no-index", "--target", folder / "site", *built.glob("*.whl")], folder)
    return folder / "site"


def run(command, folder, *more, code=0):
    """Run a command in a folder, with further folders for Python to look into; its stdout and stderr."""
    paths = os.pathsep.join(map(str, [*more, ROOT / "src"]))
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run([*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stdout, done.stderr


def tierod(folder, *arguments, site, code=0):
    sites = [site] if isinstance(site, Path) else site
    return run([sys.executable, "-m", "tierod", *arguments], folder, *sites, code=code)


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
    listed = json.loads(tierod(tmp_path, "monitors", "--json", site=installed)[0])["monitors"]
    packages = {each["name"]: each["package"] for each in listed}
    assert packages["wheel-imbalance"] == "tierod-wheel-imbalance 0.1.0"
    assert packages["friction"] == "tierod"
    assert "Package: tierod-wheel-imbalance 0.1.0" in tierod(tmp_path, "monitors", "wheel-imbalance", site=installed)[0]
    result = tierod(
        tmp_path, "diagnose", "drive.wim", "--vehicle", "balancing-car", "--json", "--memory", "m.json", site=installed,
        code=1,
    )[0]  # fmt: skip
    finding = json.loads(result)["findings"][0]
    assert finding["monitor"] == "wheel-imbalance"
    assert finding["status"] == "fault"
    assert finding["estimate"]["value"] == pytest.approx(0.3, abs=0.05)
    assert (tmp_path / "drive-wheel-imbalance.html").is_file()
    run_again = ("diagnose", "drive.wim", "--vehicle", "balancing-car", "--monitor", "wheel-imbalance", "--no-report")
    tierod(tmp_path, *run_again, site=installed, code=1)
    inspected = json.loads(tierod(tmp_path, "inspect", "drive.wim", "--json", site=installed)[0])
    assert inspected["metadata"]["format"] == "WIM"
    assert {each["name"]: each["can_run"] for each in inspected["monitors"]}["wheel-imbalance"]
    formats = json.loads(tierod(tmp_path, "formats", "--json", site=installed)[0])
    assert ["wim", "WIM (.wim)", "tierod-wheel-imbalance 0.1.0"] in [[*each.values()] for each in formats["read"]]
    assert formats["written"][-1]["ending"] == ".wim"


def test_vehicle_fault_and_scenario_stand_in_the_lists(installed, tmp_path):
    for command, name in (("vehicles", "balancing-car"), ("faults", "shaken-torque"), ("scenarios", "motorway-shaken")):
        assert name in tierod(tmp_path, command, site=installed)[0]
        assert name in tierod(tmp_path, command, name, site=installed)[0]
    tierod(tmp_path, "simulate", "motorway-shaken", "-o", "drive.parquet", site=installed)
    report = json.loads(tierod(tmp_path, "inspect", "drive.parquet", "--json", site=installed)[0])
    assert "driver_torque" in {each["name"] for each in report["channels"]}


def test_a_monitor_is_run_as_an_object(installed, tmp_path):
    text = f"""{DRIVE}
from tierod_wheel_imbalance.monitor import WHEEL_IMBALANCE
found = [tierod.diagnose(drive, "balancing-car", monitor=each) for each in (
    WHEEL_IMBALANCE, WHEEL_IMBALANCE.variants["demodulation"], "wheel-imbalance")]
assert len({{each.findings[0].headline for each in found}}) == 1
assert found[0].findings[0].status is tierod.Status.FAULT
"""
    python(tmp_path, text, installed)


@pytest.mark.parametrize(
    ("value", "text", "sentence"),
    [
        ("broken:MONITOR", "import no_such_library", "cannot be imported (ModuleNotFoundError: No module"),
        ("broken:MONITOR", "", "cannot be imported (AttributeError"),
        ("broken:MONITOR", "raise SystemExit('stop')", "cannot be imported (SystemExit: stop)"),
        ("broken:MONITOR", "MONITOR = object()", "is of the type 'object'; expected a tierod.Monitor"),
        (
            "broken:MONITOR",
            "from tierod import Monitor\nMONITOR = Monitor('broken', '', '', '', (), (), 1.0, 1.0, 1.0, {}, None)",
            "has no variant",
        ),
        (
            "broken:MONITOR",
            "from tierod import Monitor, Variant\n"
            "MONITOR = Monitor('other', '', '', '', (), (), 1.0, 1.0, 1.0, {'a': Variant('a', '', '', print)}, 'a')",
            "calls itself 'other'",
        ),
    ],
)  # fmt: skip
def test_a_broken_monitor_is_named_with_its_package_and_all_else_goes_on(tmp_path, value, text, sentence):
    site = package(tmp_path / "site", "broken-package", "tierod.monitors", "broken", value, text)
    out, said = tierod(tmp_path, "monitors", "--json", site=site)
    assert "friction" in {each["name"] for each in json.loads(out)["monitors"]}
    assert said.startswith("tierod: the monitor 'broken' of the package broken-package 1.0 ")
    assert sentence in said
    assert "pip uninstall broken-package" in said
    assert said.count("\n") == 1
    said = tierod(tmp_path, "monitors", "broken", site=site, code=3)[1]
    assert sentence in said
    assert said.count("\n") == 1
    assert tierod(tmp_path, "monitors", "friction", site=site)[1] == ""


def test_a_session_that_lacks_a_part_is_named(tmp_path):
    text = f"""{DRIVE}
class Session:
    signals, traces = ("vehicle_speed",), {{}}
half = tierod.Variant("half", "", "", lambda *given: Session())
monitor = tierod.Monitor("mine", "", "", "", ("vehicle_speed",), (), 100.0, 1.0, 0.1, {{"half": half}}, "half")
tierod.diagnose(drive, "midsize-eps", monitor=monitor)
"""
    said = python(tmp_path, text, code=1)[1]
    assert "the session of the monitor 'mine', variant 'half', lacks refuse, absorb, conclude" in said


def test_two_packages_with_one_name(tmp_path):
    sites = [
        package(tmp_path / name, name, "tierod.vehicles", "twin", name, "") for name in ("first-car", "second-car")
    ]
    out, said = tierod(tmp_path, "vehicles", site=sites)
    assert "midsize-eps" in out
    assert "the packages first-car 1.0 and second-car 1.0 both register a vehicle 'twin'" in said
    said = tierod(tmp_path, "vehicles", "twin", site=sites, code=3)[1]
    assert "pip uninstall second-car" in said


def test_a_name_of_tierod_stays_its_own(tmp_path):
    site = package(tmp_path / "site", "other-friction", "tierod.monitors", "friction", "other:MONITOR", "MONITOR = 1")
    out, said = tierod(tmp_path, "monitors", "--json", site=site)
    assert [each["package"] for each in json.loads(out)["monitors"] if each["name"] == "friction"] == ["tierod"]
    assert "the monitor 'friction' of the package other-friction 1.0 is not used" in said


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
        ("ODD\n" if code else "") + "time [s],yaw_rate [rad/s]\n" + rows, encoding="utf-8"
    )
    said = tierod(tmp_path, "inspect", "drive.odd", site=site, code=code)[1]
    assert sentence in said


def test_usual_names_and_files_search_no_installed_package(tmp_path):
    text = f"""{DRIVE}
import sys
tierod.write(drive, "drive.csv")
before = set(sys.modules)
tierod.read("drive.csv")
from tierod.core import plugins
from tierod.io.readers import READERS
from tierod.io.writers import WRITERS
from tierod.monitors.registry import MONITORS
from tierod.vehicles import VEHICLES
MONITORS.required("friction"), VEHICLES.find("midsize-eps")
assert not any("_plugins" in vars(each) for each in (READERS, WRITERS, MONITORS, VEHICLES))
"""
    python(tmp_path, text)


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("lonely", "the vehicle 'lonely' of the package lonely-car 1.0 lacks its file"),
        ("lonely:CAR", "names str where a package is expected, in whose folder lonely.toml lies"),
    ],
)
def test_a_vehicle_without_its_file_is_named(tmp_path, value, sentence):
    site = package(tmp_path / "site", "lonely-car", "tierod.vehicles", "lonely", value, "CAR = 'lonely.toml'")
    said = tierod(tmp_path, "vehicles", "lonely", site=site, code=3)[1]
    assert sentence in said
    assert "pip uninstall lonely-car" in said
    assert "midsize-eps" in tierod(tmp_path, "vehicles", site=site)[0]
