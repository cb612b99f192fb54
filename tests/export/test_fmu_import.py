"""A unit takes the place of our plant, with our driver, sensors and faults; what is wrong with it is one sentence."""

import pickle
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from exported_c import needs_gcc
from foreign_units import PLANT, Looped, Trolley, crashing, exported, of_python, without_binary
from tierod.cli import main
from tierod.core.errors import InputError, ParameterError
from tierod.core.toml import Document
from tierod.experiments.plant_proposal import plant_document, propose_plant
from tierod.proving_ground.faults import fault_of
from tierod.proving_ground.foreign import read_unit
from tierod.proving_ground.scenarios import load
from tierod.proving_ground.scenarios.plants import with_plant
from tierod.proving_ground.scenarios.reader import from_document

pytest.importorskip("fmpy", reason="fmpy is not installed")

pytestmark = needs_gcc


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A trolley as a unit, with its plant file."""
    place = tmp_path_factory.mktemp("units")
    exported(Trolley(), place / "trolley.fmu")
    (place / "trolley.toml").write_text(PLANT.replace("LASTS", "1e9"))
    return place


@pytest.fixture(scope="module")
def mixed():
    return load("mixed-drive-healthy").with_run(6.0)


def driven(scenario, document):
    return with_plant(scenario, document)[0].run()


def changed(folder, old, new):
    return Document.parse(PLANT.replace("LASTS", "1e9").replace(old, new), folder / "changed.toml", "plant")


SCENARIO = """
name = "faults of a plant"
description = "In a parameter, in a loop, in a sensor, and what is around the car."
car = "midsize-eps"
course = "mixed"
seconds = 8
faults = [
    { element = "steering.friction.level", behaviour = "step", size = "8 N*m", start = "2 s" },
    { element = "loop.driver_torque", behaviour = "offset", size = "1 N*m", start = "3 s" },
    { element = "sensor.yaw_rate", behaviour = "gain", size = 1.2, start = "4 s" },
    { element = "road.adhesion_left", behaviour = "gain", size = 0.5, start = "5 s" },
]
"""


def test_our_own_plant_as_a_unit_drives_as_without_it(tmp_path):
    assert main(["export", "fmu", "plant", "--scenario", "mixed-drive-healthy", "-o", str(tmp_path / "car.fmu")]) == 0
    scenario = from_document(Document.parse(SCENARIO, tmp_path / "s.toml"))
    ours, theirs = scenario.run(), driven(scenario, plant_document(tmp_path / "car.fmu")[0])
    assert theirs.reason == ""
    assert set(ours.recording.names) == set(theirs.recording.names)
    for name, each in ours.recording.channels.items():
        other = theirs.recording.channels[name]
        np.testing.assert_allclose(other.time, each.time, rtol=0.0, atol=0.0)
        np.testing.assert_allclose(other.values, each.values, rtol=0.0, atol=1e-9 * max(np.ptp(each.values), 1e-9))
    healthy = load("mixed-drive-healthy").with_run(8.0).run().recording
    assert np.abs(healthy["driver_torque"].values - ours.recording["driver_torque"].values).max() > 0.1


def test_our_driver_keeps_a_vehicle_of_another_make_on_its_path(folder, mixed):
    outcome = driven(mixed.with_run(20.0), Document.read(folder / "trolley.toml", "plant"))
    assert (outcome.reason, outcome.diverged_at) == ("", None)
    found = {name: each.values for name, each in outcome.recording.channels.items()}
    assert np.abs(found["truth_lateral_offset"]).max() < 0.5
    assert found["truth_distance"][-1] > 50.0
    assert "v_kmh" in outcome.recording.metadata["plant_wiring"]
    assert found["vehicle_speed"].max() < 20.0
    np.testing.assert_allclose(
        np.gradient(found["truth_distance"], 0.01)[5:-5], found["truth_vehicle_speed"][5:-5], atol=0.05
    )
    moved = np.abs(np.diff(found["truth_steering_wheel_angle"])).max()
    assert 0.0 < moved < 0.2


def test_a_fault_acts_on_what_a_unit_is_given(folder, mixed):
    table = {"element": "actuator.drive_force", "behaviour": "gain", "size": 0.0, "start": "2 s"}
    document = Document.read(folder / "trolley.toml", "plant")
    scenario, _ = with_plant(mixed, document)
    fault = fault_of(table, Document({}, "", folder / "f.toml"), ())
    speeds = []
    for faults in ((), (fault,)):
        found = replace(scenario, faults=faults).run().recording["truth_vehicle_speed"].values
        speeds.append(found)
    assert np.array_equal(speeds[0][:200], speeds[1][:200])
    assert np.ptp(speeds[1][205:]) == 0.0 < np.ptp(speeds[0][205:])


def test_a_unit_that_fails_in_a_step_leaves_the_drive_up_to_there(folder, mixed):
    outcome = driven(mixed, changed(folder, "lasts = 1e9", "lasts = 3.0"))
    assert outcome.diverged_at == pytest.approx(3.0, abs=0.01)
    assert "trolley.fmu at 3" in outcome.reason
    assert "no longer finite" in outcome.reason
    assert outcome.recording["truth_vehicle_speed"].time[-1] == pytest.approx(3.0, abs=0.011)


def test_a_unit_that_crashes_leaves_the_drive_up_to_there(tmp_path, mixed, monkeypatch):
    crashing(tmp_path / "trolley.fmu", monkeypatch)
    (tmp_path / "trolley.toml").write_text(PLANT.replace("LASTS", "1e9"))
    outcome = driven(mixed, Document.read(tmp_path / "trolley.toml", "plant"))
    assert "has crashed (by signal 6) in the step at 1" in outcome.reason
    assert outcome.diverged_at == pytest.approx(1.0, abs=0.01)


def test_a_car_of_a_unit_goes_from_process_to_process(folder, mixed):
    car = with_plant(mixed, Document.read(folder / "trolley.toml", "plant"))[0].car
    again = pickle.loads(pickle.dumps(car))
    assert again == car
    assert type(again) is type(car)


def test_a_scenario_names_its_plant(folder):
    text = 'name = "s"\ndescription = "d"\ncar = "midsize-eps"\ncourse = "mixed"\nseconds = 1\nplant = "PLANT"\n'
    (folder / "s.toml").write_text(text.replace("PLANT", "trolley.toml"))
    scenario = load(folder / "s.toml")
    assert {"trolley.toml", "trolley.fmu"} <= set(scenario.files)
    assert "vehicle_speed" in scenario.run().recording
    (folder / "s.toml").write_text(text.replace("PLANT", "none.toml"))
    with pytest.raises(ParameterError, match=r"s.toml, line 6: .*none.toml"):
        load(folder / "s.toml")
    (folder / "s.toml").write_text(text.replace("PLANT", "trolley.fmu"))
    with pytest.raises(ParameterError, match=r"line 6: 'trolley.fmu' is a unit, but 'plant' needs the plant file"):
        load(folder / "s.toml")


def test_a_plant_file_is_proposed_from_names_and_units(folder):
    found = propose_plant(read_unit(folder / "trolley.fmu"))
    assert {each.variable: each.signal for each in found.inputs} == {
        "steer_angle_deg": "steering_wheel_angle", "long_force": "drive_force",
    }  # fmt: skip
    assert {each.signal: each.unit for each in found.outputs} == {
        "vehicle_speed": "km/h", "yaw_rate": "deg/s", "lateral_speed": "m/s",
    }  # fmt: skip
    assert found.start is not None
    assert found.start.variable == "v0"
    document = Document.parse(found.text("trolley.fmu"), folder / "p.toml", "plant")
    assert {**found.content, "fmu": "trolley.fmu"} == document.content


SLIPS = {
    "no such input": ("long_force =", "longforce =", "has no input 'longforce'; did you mean 'long_force'"),
    "no such output": ('"v_kmh"', '"v_kph"', "has no output 'v_kph'; did you mean 'v_kmh'"),
    "not ours": ('"drive_force"', '"drive_farce"', "is called 'drive_farce'; did you mean 'drive_force'"),
    "no signal": ("yaw_rate = {", "yaw_rat = {", "no signal is called 'yaw_rat'"),
    "another unit": ('"v_kmh"', '{ variable = "v_kmh", unit = "kg" }', "cannot become 'm/s'"),
    "no parameter": ("lasts", "lust", "has no parameter 'lust'"),
    "a needed output": ('vehicle_speed = "v_kmh"\n', "", "our driver needs a speed"),
    "a step": ("[inputs]", "step = 0.5\n[inputs]", "a step of 0.5 s"),
    "a sign": ("sign = -1", "sign = 2", "'sign' has to be 1 or -1"),
    "a key": ("start_speed", "startspeed", "startspeed"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_plant_file_is_one_sentence(folder, mixed, slip):
    old, new, message = SLIPS[slip]
    with pytest.raises(ParameterError, match=".") as caught:
        with_plant(mixed, changed(folder, old, new))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_algebraic_loop_is_refused_or_broken(tmp_path, mixed):
    exported(Looped(), tmp_path / "looped.fmu")
    document = plant_document(tmp_path / "looped.fmu")[0]
    with pytest.raises(ParameterError, match="an algebraic loop: 'steering_wheel_angle' of the unit depends"):
        with_plant(mixed, document)
    broken = Document({**document.content, "break_loops": True}, "", document.path)
    assert with_plant(mixed, broken)[0].run().reason == ""


def test_what_is_no_unit_for_this_platform_is_one_sentence(folder, tmp_path):
    with pytest.raises(InputError, match="holds binaries for win64 and none for this platform"):
        read_unit(without_binary(folder / "trolley.fmu", tmp_path / "w.fmu"))
    (tmp_path / "text.fmu").write_text("no archive")
    with pytest.raises(InputError, match="is not a functional mock-up unit"):
        read_unit(tmp_path / "text.fmu")
    with zipfile.ZipFile(tmp_path / "empty.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<nothing")
    with pytest.raises(InputError, match="no description that can be read"):
        read_unit(tmp_path / "empty.fmu")
    with pytest.raises(InputError, match="there is no file"):
        read_unit(tmp_path / "none.fmu")


def edited(folder, target, old, new):
    """The trolley with another description."""
    with zipfile.ZipFile(folder / "trolley.fmu") as given, zipfile.ZipFile(target, "w") as made:
        for name in given.namelist():
            content = given.read(name)
            if name == "modelDescription.xml":
                assert old.encode() in content
                content = content.replace(old.encode(), new.encode())
            made.writestr(name, content)
    return target


def test_a_damaged_archive_is_one_sentence(folder, tmp_path, mixed):
    whole = (folder / "trolley.fmu").read_bytes()
    for name, content in (("half", whole[: len(whole) // 2]), ("short", whole[:-10]), ("nothing", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=f"{name} is not a functional mock-up unit: File is not a zip file"):
            read_unit(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "other.fmu", "w") as archive:
        archive.writestr("readme.txt", "text")
    with pytest.raises(InputError, match=r"it has no modelDescription\.xml; export it anew"):
        read_unit(tmp_path / "other.fmu")
    with zipfile.ZipFile(folder / "trolley.fmu") as given, zipfile.ZipFile(tmp_path / "trolley.fmu", "w") as made:
        for name in given.namelist():
            made.writestr(name, b"no library" if name.startswith("binaries") else given.read(name))
    (tmp_path / "t.toml").write_text(PLANT.replace("LASTS", "1e9"))
    with pytest.raises(InputError, match=r"the unit trolley\.fmu cannot be loaded: .*; export it anew") as caught:
        driven(mixed, Document.read(tmp_path / "t.toml", "plant"))
    assert "\n" not in str(caught.value)


def test_another_version_of_the_standard_and_another_kind_are_named(folder, tmp_path):
    old = edited(folder, tmp_path / "old.fmu", 'fmiVersion="2.0"', 'fmiVersion="1.0"')
    with pytest.raises(InputError, match=r"is a unit of FMI 1\.0, and only 2 and 3 can be run"):
        read_unit(old)
    solverless = edited(folder, tmp_path / "solverless.fmu", "CoSimulation", "ModelExchange")
    with pytest.raises(InputError, match="is for model exchange alone; export it for co-simulation"):
        read_unit(solverless)


def test_variables_in_other_units_of_measurement_are_converted_refused_or_named(folder, tmp_path, mixed):
    def plant(name, new, old='"km/h"'):
        edited(folder, tmp_path / f"{name}.fmu", old, new)
        text = PLANT.replace("LASTS", "1e9").replace("trolley", name)
        return Document.parse(text, tmp_path / f"{name}.toml", "plant")

    miles = with_plant(mixed, plant("miles", '"mph"'))[0].car.wires.outputs
    assert {each.signal: each.gain for each in miles}["vehicle_speed"] == pytest.approx(0.44704)
    with pytest.raises(ParameterError, match="'v_kmh': the unit 'kg' cannot become 'm/s': they are units of different"):
        with_plant(mixed, plant("mass", '"kg"'))
    warned = with_plant(mixed, plant("bare", "", ' unit="km/h"'))[1]
    assert any("states no unit of measurement for v_kmh [m/s]: taken as they are" in each for each in warned)
    assert not any("no unit of measurement" in each for each in with_plant(mixed, plant("whole", '"km/h"'))[1])


def test_the_command_line_drives_a_unit_and_writes_its_plant_file(folder, tmp_path, capsys):
    unit = str(folder / "trolley.fmu")
    assert main(["inspect", unit, "--write-map", str(tmp_path / "car.plant.toml")]) == 0
    assert "steering_wheel_angle" in capsys.readouterr().out
    drive = str(tmp_path / "drive.parquet")
    given = ["simulate", "mixed-drive-healthy", "--seconds", "20", "-o", drive, "--plant"]
    turned = (folder / "trolley.toml").read_text().replace('deg_s", sign = -1', 'deg_s"')
    (folder / "turned.toml").write_text(turned)
    assert main([*given, str(folder / "turned.toml")]) == 0
    assert "leaves its path by more than 10 m" in capsys.readouterr().err
    assert main([*given, str(folder / "trolley.toml")]) == 0
    shown = capsys.readouterr()
    assert "measured channels" in shown.out
    assert "takes no road.bank_angle" in shown.err
    assert f"{folder / 'trolley.fmu'} runs its own native code on this computer" in shown.err
    assert "leaves its path" not in shown.err


def test_a_unit_of_another_exporter_drives(tmp_path, mixed):
    pytest.importorskip("pythonfmu", reason="pythonfmu is not installed")
    document = plant_document(of_python(tmp_path))[0]
    outcome = driven(mixed, document)
    assert (outcome.reason, outcome.diverged_at) == ("", None)
    assert np.abs(outcome.recording["truth_lateral_offset"].values).max() < 0.5
    failing = Document({**document.content, "values": {"fails_at": 2.0}}, "", document.path)
    outcome = driven(mixed, failing)
    assert outcome.diverged_at == pytest.approx(2.0, abs=0.01)
    assert "fails in a step" in outcome.reason
