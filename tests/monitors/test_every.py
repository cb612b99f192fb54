"""A diagnosis by every monitor runs those that an inspection calls able, and says of the others what it says."""

import os
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from tierod.cli import main
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.diagnose import judge
from tierod.monitors.inspection import inspect
from tierod.report.display import without_advice
from tierod.vehicles import load
from tierod.vehicles.classes import typical
from tierod_lab.ground import drive
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.sensors import SensorSet

WHEELS = tuple(f"wheel_speed_{place}" for place in ("front_left", "front_right", "rear_left", "rear_right"))
MOTION = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "longitudinal_acceleration")
BUS = (*CHANNELS, *WHEELS, "longitudinal_acceleration")


CAR = load("midsize-eps")
CAR = replace(CAR, parameters={**typical("midsize"), **CAR.parameters})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("drives")
    write(drive(minutes=2.5, seed=3, sensors=SensorSet.production().only(BUS)), place / "drive.parquet")
    for name, scenario, seconds in (("wire", "steer-by-wire-lane-change", "8"), ("motor", "motor-bench-sweep", "1")):
        assert main(["simulate", scenario, "-o", str(place / f"{name}.parquet"), "--seconds", seconds, "--json"]) == 0
    return place


def with_only(folder, name, kept, new):
    """A recording with some of its channels alone."""
    whole = read(folder / f"{name}.parquet")
    channels = {each: channel for each, channel in whole.channels.items() if each in kept}
    path = folder / f"{new}.parquet"
    write(replace(whole, channels=channels), path)
    return path


PARTS = {
    "motion": MOTION,
    "slip": (*MOTION, "steering_wheel_angle"),
    "wheels": WHEELS,
    "no motor": (*MOTION, "steering_wheel_angle", "steering_wheel_rate", "driver_torque"),
    "column": ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque"),
}
CASES = [("drive", "midsize-eps"), ("wire", "steer-by-wire"), ("motor", "motor-bench"), ("motor", "midsize-eps")]


def agree(path, car):
    """Require that inspection and diagnosis say the same of every monitor, and give what was judged."""
    judged, said = judge(path, car, spread=False), inspect(path, car)
    reasons = {name: without_advice(reason) for name, reason in judged.not_run}
    for each in said.monitors:
        name = each.monitor.name
        if each.monitor.default is None and each.variants:
            assert reasons[name] == f"can run{each.choice}, with --monitor {name}"
        elif each.variants:
            assert name in judged.diagnoses, reasons.get(name)
            assert judged.diagnoses[name].findings[0].monitor.startswith(f"{name}, {each.variants[0]}")
        else:
            assert reasons[name] == without_advice(each.reason)
    return judged


@pytest.mark.parametrize(("name", "vehicle"), CASES)
def test_it_says_what_an_inspection_says(folder, name, vehicle):
    agree(folder / f"{name}.parquet", CAR if vehicle == CAR.name else load(vehicle))


@pytest.mark.parametrize("part", PARTS)
def test_it_says_what_an_inspection_says_where_signals_are_absent(folder, part):
    judged = agree(with_only(folder, "drive", PARTS[part], part), CAR)
    ran = {"motion": set(), "slip": {"sideslip"}, "wheels": {"condition"}}
    assert judged.diagnoses.keys() == ran.get(part, judged.diagnoses.keys())


def test_without_a_look_the_recording_is_judged_all_the_same(folder, tmp_path):
    from tierod.io.conversion import convert

    convert([folder / "drive.parquet"], tmp_path / "drive.csv")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_bytes((tmp_path / "drive.csv").read_bytes()))
    writer.start()
    judged = judge(Path(pipe), CAR, spread=False)
    writer.join()
    assert {"friction", "sideslip", "condition"} <= judged.diagnoses.keys()
    assert "the vehicle moves" in dict(judged.not_run)["hysteresis"]
