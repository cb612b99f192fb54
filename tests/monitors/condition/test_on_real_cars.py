"""The condition monitor on recordings of real cars, from the console: what is missing is named, what fails is found."""

import json
import math

import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.condition.signals import ALL_WHEELS
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import OFFSET, Injected

CARS = {
    "rav4": (("rav4_highway_minute", "can.log"), {*ALL_WHEELS}, []),
    "revsted-car": (
        ("revsted_slip_angle", "obd.csv"),
        {*ALL_WHEELS, "yaw_rate", "steering_wheel_angle"},
        ["longitudinal acceleration"],
    ),
}


def recording_of(vehicle):
    if vehicle == "rav4":
        pytest.importorskip("cantools")
    return shared_data(*CARS[vehicle][0])


def diagnosed(capsys, *arguments):
    code = main(["diagnose", *map(str, arguments), "--monitor", "condition", "--no-report", "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("vehicle", CARS)
def test_a_fault_free_car_is_healthy_and_hears_what_it_lacks(vehicle, capsys):
    _, fault_free, missing = CARS[vehicle]
    code, result = diagnosed(capsys, recording_of(vehicle), "--vehicle", vehicle)
    assert code == 0
    states = {each["name"]: each["status"] for each in result["elements"]}
    assert {name for name, status in states.items() if status == "healthy"} == fault_free
    assert states["tie_rod_force"] == states["drive_left"] == "not available"
    warnings = result["findings"][0]["warnings"]
    lack = [each for each in warnings if each.startswith("without ")]
    assert len(lack) == 1
    assert all(name in lack[0] for name in ("steering shaft torque", "tie rod force", *missing))
    assert "still distinguished" in lack[0]
    assert any("a fault of both wheels of an axle at once cannot be detected" in each for each in warnings)
    assert any("a wrong scale of the steering wheel angle is not judged" in each for each in warnings)


def test_an_offset_of_the_yaw_rate_is_named_from_its_beginning_to_its_end(tmp_path, capsys):
    fault_free = complete(read(recording_of("rav4"), dbc="rav4", channel_map=load("rav4").channel_map))
    fault = Injected("yaw_rate", OFFSET, 0.3, 42.0, 48.0).fault
    write(injected(fault_free, [fault]), tmp_path / "drive.parquet")
    code, result = diagnosed(capsys, tmp_path / "drive.parquet", "--vehicle", "rav4")
    assert code == 1
    at_fault = [each for each in result["elements"] if each["status"] in ("fault", "suspect")]
    assert [each["name"] for each in at_fault] == ["yaw_rate"]
    (episode,) = at_fault[0]["episodes"]
    assert episode["kind"] == "positive offset"
    assert 42.0 <= episode["start"] <= 42.1
    assert 48.0 <= episode["end"] <= 48.5
    assert math.isclose(episode["size"]["value"], 0.3, rel_tol=0.1)


def test_without_the_steering_angle_no_fault_is_declared_and_the_reason_is_reported(tmp_path, capsys):
    fault_free = complete(read(recording_of("rav4"), dbc="rav4", channel_map=load("rav4").channel_map))
    gone = ("steering_wheel", "wheel_speed_front")
    kept = {name: each for name, each in fault_free.channels.items() if not name.startswith(gone)}
    write(Recording(kept), tmp_path / "drive.parquet")
    _, result = diagnosed(capsys, tmp_path / "drive.parquet", "--vehicle", "rav4")
    assert {each["status"] for each in result["elements"]} == {"not testable", "not available"}
    assert any(
        "steering wheel angle" in each for each in result["findings"][0]["warnings"] if each.startswith("without ")
    )
