"""The advice of a finding can be followed, and the verdict then changes."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.findings import Diagnosis, Finding
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.io.writers import write
from tierod.monitors.baseline import Baseline
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import Parameter, Vehicle, load
from tierod_lab.ground import drive, lock_to_lock
from tierod_lab.ground.scenarios import load as load_scenario

GAIN = 1.4
"""Factor on both torques of this car, so that its fault-free friction lies above the limit of the vehicle file."""


def scaled(recording: Recording, factor: float = GAIN) -> Recording:
    torques = (recording["driver_torque"], recording["motor_torque"])
    return recording.with_channels([dataclasses.replace(each, values=factor * each.values) for each in torques])


@pytest.fixture(scope="module")
def fault_free() -> Recording:
    return drive(minutes=5.0, friction=4.0, seed=31)


@pytest.fixture(scope="module")
def risen() -> Recording:
    return drive(minutes=5.0, friction=6.5, seed=32)


def guessed(name: str, deviation: float) -> Vehicle:
    car = load("midsize-eps")
    parameter = dataclasses.replace(car.parameters[name], standard_deviation=deviation)
    return dataclasses.replace(car, parameters={**car.parameters, name: parameter})


def measured(car: Vehicle, action: str) -> Vehicle:
    """The car after the parameters that an action names were measured."""
    (named,) = re.findall(r"measure (.*?) first", action)
    names = re.split(r", | and ", named)
    assert all(name in car.parameters for name in names)
    known = {name: dataclasses.replace(car.parameters[name], standard_deviation=0.0) for name in names}
    return dataclasses.replace(car, parameters={**car.parameters, **known})


def told(diagnosis: Diagnosis) -> str:
    finding = diagnosis.findings[0]
    return " ".join((finding.headline, finding.cause, finding.action, *finding.warnings)).lower()


def command_of(action: str, recording: Path) -> list[str]:
    """Arguments of the command that an action names, for a recording."""
    (command,) = re.findall(r"'tierod (diagnose [^']*)'", action)
    return [str(recording) if each == "FAULT_FREE_DRIVE" else each for each in command.split()]


def file_of(car: Vehicle, folder: Path, name: str, deviation: float) -> Path:
    """File of a shipped car with another standard deviation of one parameter."""
    lines = car.path.read_text(encoding="utf-8").splitlines()
    at = lines.index(f"[parameters.{name}]")
    lines.insert(at + 3, f"standard_deviation = {deviation}")
    path = folder / "own.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize("limit_deviation", [0.0, 1.2])
def test_a_baseline_decides_a_verdict_that_rests_on_a_guessed_limit(
    fault_free, risen, tmp_path, monkeypatch, limit_deviation
):
    monkeypatch.chdir(tmp_path)
    car = file_of(load("midsize-eps"), tmp_path, "rising_friction", limit_deviation)
    paths = {}
    for name, recording in (("own", fault_free), ("risen", risen)):
        paths[name] = tmp_path / f"{name}.parquet"
        write(scaled(recording), paths[name])
    doubted = diagnose(paths["own"], car, "friction")
    assert doubted.findings[0].status is Status.SUSPECT
    action = doubted.findings[0].action
    assert action.startswith("give a fault-free drive of this car as baseline: 'tierod diagnose")
    assert "measure rising_friction" not in told(doubted)

    assert main([*command_of(action, paths["own"]), "--no-report"]) == 1
    assert Path("my-car.json").exists()
    given = ["--vehicle", str(car), "--monitor", "friction", "--baseline", "my-car.json", "--no-report"]
    assert main(["diagnose", str(paths["own"]), *given]) == 0
    assert main(["diagnose", str(paths["risen"]), *given]) == 1
    found = diagnose(paths["risen"], car, "friction", baseline="my-car.json").findings[0]
    assert found.status in (Status.RISING, Status.FAULT)


def test_measuring_what_friction_names_decides(fault_free):
    car = guessed("motor_ratio", 4.0)
    found = diagnose(fault_free, car, "friction")
    assert found.findings[0].status is Status.NOT_IDENTIFIABLE
    assert "or measure motor_ratio first" in found.findings[0].action
    after = diagnose(fault_free, measured(car, found.findings[0].action), "friction")
    assert after.findings[0].status is Status.HEALTHY


def test_a_signal_that_was_never_there_with_the_others_is_found_as_advised(fault_free, tmp_path, capsys):
    time = fault_free["driver_torque"].time
    parts = {"driver_torque": time < 150.0, "lateral_acceleration": fault_free["lateral_acceleration"].time > 150.0}
    apart = [
        dataclasses.replace(fault_free[name], values=np.where(there, fault_free[name].values, np.nan))
        for name, there in parts.items()
    ]
    path = tmp_path / "apart.parquet"
    write(fault_free.with_channels(apart), path)
    found = diagnose(path, "midsize-eps", "friction").findings[0]
    assert found.status is Status.NOT_AVAILABLE
    assert "find the missing signal with 'tierod inspect'" in found.action
    capsys.readouterr()
    main(["inspect", str(path), "--vehicle", "midsize-eps"])
    shown = capsys.readouterr().out
    for name in parts:
        assert any(name in line and "50" in line for line in shown.splitlines())
    assert diagnose(fault_free, "midsize-eps", "friction").findings[0].status is Status.HEALTHY


@pytest.fixture(scope="module")
def column() -> Recording:
    return dataclasses.replace(load_scenario("hands-off"), faults=()).with_run(None, 72).run().recording


def test_a_sign_that_is_corrected_as_advised_makes_the_hands_testable(column, tmp_path):
    path = tmp_path / "turned.parquet"
    write(
        column.with_channels([dataclasses.replace(column["driver_torque"], values=-column["driver_torque"].values)]),
        path,
    )
    found = diagnose(path, "midsize-eps", "driver-torque").findings[0]
    assert found.status is Status.NOT_TESTABLE
    assert "correct the channel map" in found.action
    ((name, factor),) = re.findall(r"(\w+) has the wrong sign.*\(factor (-?\d+)\)", found.cause)
    channel_map = tmp_path / "signs.toml"
    channel_map.write_text(f'[signals.{name}]\nsource = "{name}"\nunit = "N*m"\nfactor = {factor}\n', encoding="utf-8")
    after = diagnose(path, "midsize-eps", "driver-torque", channel_map=channel_map).findings[0]
    assert after.status is Status.CONSISTENT


def test_a_vehicle_file_that_is_corrected_as_advised_is_consistent(column):
    car = load("midsize-eps")
    stiff = dataclasses.replace(car.parameters["torsion_bar_stiffness"], value=210.0)
    wrong = dataclasses.replace(car, parameters={**car.parameters, stiff.name: stiff})
    found = diagnose(column, wrong, "driver-torque").findings[0]
    assert found.status is Status.INCONSISTENT
    assert found.action.startswith("correct the vehicle file")
    ((name, value),) = re.findall(r"(\w+) is 210 N·m/rad, but the twist of the bar shows (\d+)", found.cause)
    right = dataclasses.replace(wrong.parameters[name], value=float(value))
    corrected = dataclasses.replace(wrong, parameters={**wrong.parameters, name: right})
    assert diagnose(column, corrected, "driver-torque").findings[0].status is Status.CONSISTENT


TRUE = 4.0


def calibrated(deviation: float) -> Vehicle:
    car = load("midsize-eps")
    known = Parameter("torque_gain_deviation", deviation, "", None, "calibration")
    return dataclasses.replace(car, parameters={**car.parameters, known.name: known})


def judged(recording: Recording, vehicle: Vehicle | str = "midsize-eps") -> Finding:
    return diagnose(recording, vehicle, "friction").findings[0]


@pytest.mark.parametrize("gain", [0.86, 1.0, 1.14])
def test_the_interval_holds_the_truth_for_a_gain_within_the_assumption(fault_free, gain):
    found = judged(scaled(fault_free, gain))
    assert found.estimate is not None
    assert abs(found.estimate.value - TRUE) < 1.96 * found.estimate.standard_deviation
    assert "torque gains ± 8 % included" in found.details


def test_friction_far_below_nominal_is_healthy_with_a_remark_and_its_cure(fault_free):
    car = load("midsize-eps")
    known = {name: each for name, each in car.parameters.items() if not name.startswith("assist_")}
    without_map = dataclasses.replace(car, parameters=known)
    low, usual = (judged(each, without_map) for each in (scaled(fault_free, 0.6), fault_free))
    assert low.status is usual.status is Status.HEALTHY
    share = low.estimate.value / 4.0
    assert f"only {share:.2f} times nominal" in low.details
    assert "the gains of driver_torque and motor_torque" in low.cause
    assert "another car" in low.cause
    assert "judge against this car's baseline" in low.action
    assert "times nominal" not in " ".join((*usual.details, usual.cause, *usual.warnings))


@pytest.mark.parametrize("against", ["nominal", "baseline"])
def test_a_loop_far_narrower_than_expected_is_not_as_expected(against):
    test = lock_to_lock(TRUE, hoist=True, seed=6)
    own = None
    if against == "baseline":
        own = Baseline("midsize-eps", "hysteresis, hoist", TRUE, 0.02, "N*m", 60.0, rate=1.0)
    low, usual = (
        diagnose(each, "midsize-eps", "hysteresis", "hoist", baseline=own, spread=False).findings[0]
        for each in (scaled(test, 0.6), test)
    )
    assert low.status is usual.status is Status.HEALTHY
    assert "only 0.5" in low.cause
    assert "the gains of driver_torque and motor_torque" in low.cause
    assert "calibrate driver_torque and motor_torque" in low.action
    assert ("--baseline" in low.action) == (own is None)
    assert usual.cause == "the loop is as wide as expected"
    assert usual.action == "none"


def test_a_gain_that_may_hide_a_fault_leaves_no_verdict(fault_free):
    found = judged(fault_free, calibrated(0.6))
    assert found.status is Status.NOT_IDENTIFIABLE
    assert found.headline == "Friction: not identifiable, torque_gain_deviation decides the verdict"
    assert found.action.startswith("give a fault-free drive of this car as baseline")
    assert judged(fault_free, calibrated(0.2)).status is Status.HEALTHY
