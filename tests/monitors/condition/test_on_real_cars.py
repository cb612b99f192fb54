"""Recordings of real cars: what is missing is named, what fails is found, and guessed vehicle files accuse nothing."""

import json
import math

import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.condition.signals import ALL_WHEELS
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import OFFSET, Injected
from tierod_lab.papers.own_car.brochure import brochure_car

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
    (lack,) = [each for each in warnings if each.startswith("without ")]
    assert all(name in lack for name in ("steering shaft torque", "tie rod force", "still distinguished", *missing))
    assert any("a fault of both wheels of an axle at once cannot be detected" in each for each in warnings)
    assert any("a wrong scale of the steering wheel angle is not judged" in each for each in warnings)


def test_an_offset_of_the_yaw_rate_is_named_and_without_the_angle_none_is_declared_with_the_reason(tmp_path, capsys):
    sound = complete(read(recording_of("rav4"), dbc="rav4", channel_map=load("rav4").channel_map))
    write(injected(sound, [Injected("yaw_rate", OFFSET, 0.3, 42.0, 48.0).fault]), tmp_path / "drive.parquet")
    code, result = diagnosed(capsys, tmp_path / "drive.parquet", "--vehicle", "rav4")
    assert code == 1
    (element,) = [each for each in result["elements"] if each["status"] in ("fault", "suspect")]
    (episode,) = element["episodes"]
    assert (element["name"], episode["kind"]) == ("yaw_rate", "positive offset")
    assert 42.0 <= episode["start"] <= 42.1
    assert 48.0 <= episode["end"] <= 48.5
    assert math.isclose(episode["size"]["value"], 0.3, rel_tol=0.1)
    gone = ("steering_wheel", "wheel_speed_front")
    write(Recording({name: each for name, each in sound.channels.items() if not name.startswith(gone)}),
          tmp_path / "few.parquet")  # fmt: skip
    _, result = diagnosed(capsys, tmp_path / "few.parquet", "--vehicle", "rav4")
    assert {each["status"] for each in result["elements"]} == {"not testable", "not available"}
    (lack,) = [each for each in result["findings"][0]["warnings"] if each.startswith("without ")]
    assert "steering wheel angle" in lack


@pytest.mark.parametrize("kind", ["small", "midsize", "van"])
def test_a_guessed_file_accuses_no_sensor_of_a_fault_free_drive_and_names_a_fault(kind):
    bends = read(recording_of("revsted-car"), channel_map=load("revsted-car").channel_map)
    car = brochure_car("guessed", kind, 1700.0, 2.7)
    assert diagnose(bends, car, "condition").findings[0].status is Status.HEALTHY
    fault = Injected("yaw_rate", OFFSET, 0.3, bends.span[0] + 10.0, bends.span[0] + 14.0).fault
    found = diagnose(injected(bends, [fault]), car, "condition")
    assert [each.name for each in found.elements if each.status is Status.FAULT] == ["yaw_rate"]
