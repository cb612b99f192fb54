"""Several recordings and every monitor: one page, one document, the worst exit code."""

import dataclasses
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import tierod.report
from driven import drive
from tierod.cli import main
from tierod.cli.terminal import origin
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.io.writers import write
from tierod.monitors.baseline import load_baseline
from tierod.monitors.diagnose import Judged, NotRun
from tierod.monitors.diagnose import diagnose as run
from tierod.report import several
from tierod.vehicles import VEHICLES
from tierod_lab.ground.scenarios import load as load_scenario


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two recordings and a vehicle file that names no monitor."""
    place = tmp_path_factory.mktemp("drives")
    for name, seed in (("a", 3), ("b", 4)):
        write(drive(minutes=2.0, seed=seed), place / f"{name}.parquet")
    text = VEHICLES["midsize-eps"].read_text(encoding="utf-8")
    (place / "car.toml").write_text(text.replace('monitor = "friction"\n', ""), encoding="utf-8")
    return place


@pytest.fixture(autouse=True)
def _here(folder, monkeypatch):
    monkeypatch.chdir(folder)
    yield
    for page in folder.glob("*.html"):
        page.unlink()


def test_several_recordings_give_one_page_and_the_worst_code(folder, capsys):
    code = main(["diagnose", "a.parquet", "b.parquet", "--vehicle", "car.toml", "--monitor", "friction"])
    printed = capsys.readouterr().out
    assert "report: recordings-friction.html" in printed
    (page,) = folder.glob("*.html")
    text = page.read_text(encoding="utf-8")
    assert all(f"recording {name}.parquet" in text for name in "ab")
    assert code in (0, 1, 2)


def test_a_car_that_names_no_monitor_is_judged_by_every_one_that_can_run(capsys):
    code = main(["diagnose", "a.parquet", "--vehicle", "car.toml", "--no-report", "--json"])
    document = json.loads(capsys.readouterr().out)
    schema = Path(tierod.report.__file__).parent / "diagnoses.schema.json"
    jsonschema.validate(document, json.loads(schema.read_text(encoding="utf-8")))
    assert document["exit_code"] == code
    (one,) = document["recordings"]
    assert one["vehicle"] == "midsize-eps"
    assert {"friction", "sideslip"} <= one["diagnoses"].keys()
    assert {each["monitor"] for each in one["not_run"]} >= {"hysteresis", "motor-angle"}
    assert one["diagnoses"]["friction"]["findings"][0]["monitor"].startswith("friction")


def test_a_stretch_is_judged_alone(capsys):
    stretch = ["--from", "30", "--to", "90"]
    main(["diagnose", "a.parquet", "--vehicle", "midsize-eps", "--no-report", "--json", *stretch])
    (row, *_) = json.loads(capsys.readouterr().out)["quality"]
    assert row["samples"] == pytest.approx(6000, rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["a.parquet", "absent.parquet"], "there is no file absent.parquet"),
        (["a.parquet", "b.parquet", "--monitor", "frictoin"], "did you mean 'friction'"),
        (["a.parquet", "b.parquet", "--memory", "memory.json"], "--memory works with one monitor and one recording"),
        (["a.parquet", "--variant", "presliding"], "name one with --monitor"),
        (["a.parquet", "--from", "20", "--to", "10"], "--from before --to"),
        (["a.parquet", "--from", "1000"], "it covers 0"),
        (["a.parquet", "b.parquet", "--output", "a.parquet"], "would overwrite a.parquet"),
        (["a.parquet", "b.parquet", "--output", "nowhere/page.html"], "nowhere"),
        (["a.parquet", "b.parquet", "--monitor", "motor-angle"], "no monitor can run on a.parquet, b.parquet"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_written(arguments, sentence, folder, capsys):
    assert main(["diagnose", *arguments, "--vehicle", "car.toml"]) == 3
    assert sentence in capsys.readouterr().err
    assert not list(folder.glob("*.html"))
    assert not (folder / "memory.json").exists()


@pytest.mark.parametrize("place", [0, 2])
def test_a_recording_that_cannot_be_used_takes_no_verdict_from_the_others(place, folder, capsys):
    (folder / "torn.parquet").write_bytes((folder / "a.parquet").read_bytes()[:50_000])
    given = ["a.parquet", "b.parquet"]
    given.insert(place, "torn.parquet")
    code = main(["diagnose", *given, "--vehicle", "car.toml", "--monitor", "sideslip", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert document["exit_code"] == code == 2
    torn = document["recordings"].pop(place)
    assert torn["diagnoses"] == {}
    assert torn["not_run"][0]["monitor"] == "sideslip"
    assert "torn.parquet" in torn["not_run"][0]["reason"]
    assert [one["diagnoses"]["sideslip"]["exit_code"] for one in document["recordings"]] == [0, 0]
    page = (folder / "recordings-sideslip.html").read_text(encoding="utf-8")
    assert "1 of 3 recordings could not be judged: torn.parquet." in page


def test_a_recording_without_a_verdict_is_no_excuse_for_a_fault(folder):
    usual = run(folder / "a.parquet", "midsize-eps", "friction")
    faulty = dataclasses.replace(usual, findings=(dataclasses.replace(usual.findings[0], status=Status.FAULT),))
    found = [
        Judged(folder / "a.parquet", "car", {"friction": faulty}),
        Judged(folder / "b.parquet", "car", {}, (NotRun("friction", "torn"), NotRun("sideslip", "torn"))),
    ]
    assert several.status_of(found) is Status.FAULT
    assert several.not_run(found) == [("b.parquet", "all", "torn")]
    page = several.render(found, origin())
    assert "The worst of" not in page
    assert "Not judged: b.parquet." in page


def test_a_column_that_one_recording_lacks_stops_only_what_needs_it(folder, capsys):
    time = np.arange(6000) / 100.0
    names = ("driver_torque", "vehicle_speed", "yaw_rate", "steering_wheel_angle")
    table = ",".join(("time [s]", *(f"c_{name}" for name in names[1:])))
    columns = (time, 15.0 + np.cos(time), 0.1 * np.sin(time), 0.5 * np.sin(time))
    np.savetxt(folder / "part.csv", np.column_stack(columns), delimiter=",", header=table, comments="", fmt="%.5f")
    entries = "".join(f'[signals.{name}]\nsource = "c_{name}"\nunit = "{SIGNALS[name].unit}"\n' for name in names)
    (folder / "part.channels.toml").write_text(entries, encoding="utf-8")
    asked = ["diagnose", "part.csv", "--vehicle", "car.toml", "--map", "part.channels.toml", "--no-report"]
    assert main([*asked, "--monitor", "sideslip"]) in (0, 2)
    assert "Sideslip: " in capsys.readouterr().out
    assert main([*asked, "--monitor", "driver-torque"]) == 3
    refused = capsys.readouterr().err
    assert "names 'c_driver_torque' for driver_torque, which is not a column of the file" in refused
    assert "did you mean" not in refused


@pytest.fixture(scope="module")
def demonstrator():
    """A drive of the demonstrator, without truth."""
    whole = load_scenario("demonstrator-healthy").with_run(40.0, 5).run().recording
    return Recording({name: each for name, each in whole.channels.items() if not name.startswith("truth_")})


def _every_verdict(recording, folder, capsys):
    write(recording, folder / "demonstrator.parquet")
    main(["diagnose", "demonstrator.parquet", "--vehicle", "smartload", "--monitor", "all", "--no-report", "--json"])
    (document,) = json.loads(capsys.readouterr().out)["recordings"]
    return {name: each["findings"][0] for name, each in document["diagnoses"].items()}


def test_a_sensor_that_one_monitor_calls_faulty_contradicts_the_statements_of_others(demonstrator, folder, capsys):
    angle = demonstrator["steering_wheel_angle"]
    held = np.repeat(angle.values[::20], 20)[: len(angle.values)]
    held_at_5_hz = demonstrator.with_channels([dataclasses.replace(angle, values=held)])
    found = _every_verdict(held_at_5_hz, folder, capsys)
    assert found["condition"]["status"] == "fault"
    assert found["sideslip"]["status"] == "inconsistent"
    assert "steering_wheel_angle is faulty" in found["sideslip"]["cause"]
    assert "(condition)" in found["sideslip"]["cause"]
    assert "largest force" not in found["sideslip"]["headline"]
    sound = _every_verdict(demonstrator, folder, capsys)
    assert sound["condition"]["status"] == "healthy"
    assert sound["sideslip"]["status"] == "estimated"


@pytest.fixture(scope="module")
def kept_drives(tmp_path_factory):
    """Drives by what they are."""
    place_of = tmp_path_factory.mktemp("recordings")
    drives = {"healthy": drive(minutes=4.0, seed=3), "faulty": drive(minutes=4.0, friction=12.0, seed=2)}
    drives["short"] = Recording(drives["healthy"].channels).slice(0.0, 60.0)
    for name, recording in drives.items():
        write(recording, place_of / f"{name}.parquet")
    write(Recording(drives["healthy"].channels), place_of / "again.csv")
    return place_of


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def judge(recording, *arguments):
    return main(["diagnose", str(recording), "--vehicle", "midsize-eps", "--no-report", "--no-spread", *arguments])


def test_a_remark_says_whether_a_baseline_was_written_or_used(kept_drives, place, capsys):
    assert judge(kept_drives / "healthy.parquet", "--baseline", "car.json") == 0
    assert "baseline: written to car.json; later recordings are judged against it" in capsys.readouterr().out
    learnt = load_baseline("car.json").learnt
    assert judge(kept_drives / "faulty.parquet", "--baseline", "car.json") == 1
    assert f"baseline: judged against car.json, learnt {learnt}; the file stays as it is" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("recording", "arguments", "reason"),
    [
        ("faulty", (), "the verdict is 'fault', and a baseline is learnt from a healthy recording only"),
        ("short", (), "and a baseline is learnt from a healthy recording only"),
        ("healthy", ("--monitor", "sideslip"), "the monitor 'sideslip' learns no baseline"),
    ],
)
def test_a_remark_says_why_a_baseline_was_not_written(kept_drives, place, capsys, recording, arguments, reason):
    judge(kept_drives / f"{recording}.parquet", "--baseline", "car.json", *arguments)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("baseline: ")]
    assert line.startswith("baseline: car.json was not written: ")
    assert line.endswith(reason)
    assert not (place / "car.json").exists()


@pytest.mark.parametrize(
    ("again", "arguments"),
    [("again.csv", ()), ("healthy.parquet", ("--variant", "refined"))],
    ids=["another file of the same samples", "another variant"],
)
def test_a_recording_that_is_judged_twice_counts_once(kept_drives, place, capsys, again, arguments):
    assert judge(kept_drives / "healthy.parquet", "--memory", "memory.json") == 0
    assert "fault memory: the recording is operation cycle 1 of the fault memory memory.json" in capsys.readouterr().out
    before = (place / "memory.json").read_bytes()
    assert judge(kept_drives / again, "--memory", "memory.json", *arguments) == 3
    error = capsys.readouterr().err
    assert "already contains this recording, as operation cycle 1 on 20" in error
    assert "nothing was changed. Judge it again without the memory" in error
    assert (place / "memory.json").read_bytes() == before


def test_a_memory_that_was_cleared_takes_the_recording_again(kept_drives, place):
    judge(kept_drives / "faulty.parquet", "--memory", "memory.json")
    assert main(["faults", "clear", "memory.json"]) == 0
    assert judge(kept_drives / "faulty.parquet", "--memory", "memory.json") == 1
    assert FaultMemory.opened("memory.json", "midsize-eps").cycles == 2
