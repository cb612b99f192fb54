import math
from dataclasses import replace

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding, recording, vehicle_with
from said import estimated, said
from tierod.core.errors import InputError
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.diagnosis.fault_memory import FaultMemory
from tierod_lab.papers.motor_angle.bench import RATE, drive
from tierod_lab.papers.motor_angle.sensor_faults import FAULTS, FIVE_DEGREES, offset

ANGLE = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]]
LATE = np.arange(len(ANGLE)) >= 62_000


def diagnosed(samples, **more):
    return diagnose(recording(samples), "motor-bench", "motor-angle", **more)


def test_a_fault_free_drive():
    diagnosis = diagnosed(FAULT_FREE().samples)
    found = diagnosis.findings[0]
    assert found.status is Status.HEALTHY
    assert found.evidence["turning_s"] > 1.0
    assert found.evidence["sensor_turns_per_observed_turn"] == pytest.approx(1.0, abs=0.002)
    assert abs(found.estimate.value) < 0.01
    assert np.nanmax(np.abs(diagnosis.traces["angle_residual_electrical"].upper)) < 0.1
    drawn = np.isfinite(diagnosis.traces["motor_speed_residual"].mean)
    assert (drawn[1:] & drawn[:-1]).sum() > 0.5 * drawn.sum()


def test_an_offset_with_its_size_and_its_beginning():
    found = finding(changed(motor_angle_mechanical=ANGLE + FIVE_DEGREES * LATE))
    assert found.status is Status.FAULT
    assert found.since == pytest.approx(6.22, abs=0.02)
    assert found.estimate.value == pytest.approx(math.radians(5.0), abs=0.02)
    assert "differs from the angle that currents and voltages give" in said(found)


def test_a_drive_too_slow_is_not_judged():
    samples = FAULT_FREE().samples[:52_000]
    assert finding(samples).status is Status.NOT_ENABLED


def test_an_electrical_angle_given_as_mechanical_is_named():
    found = finding(changed(motor_angle_mechanical=4.0 * ANGLE))
    assert found.status is Status.NOT_TESTABLE
    assert "electrical, but named as mechanical" in found.cause


@pytest.mark.parametrize("pairs", [3.0, 5.0])
def test_a_wrong_pole_pair_number_is_named(pairs):
    found = finding(FAULT_FREE().samples, vehicle_with(motor_pole_pairs=pairs))
    assert found.status is Status.NOT_TESTABLE
    assert "as with 4 pole pairs" in found.cause


def test_currents_that_come_too_slowly_are_refused():
    slow = FAULT_FREE().samples[::2]
    channels = recording(slow).channels
    late = {name: replace(each, time=2.0 * each.time) for name, each in channels.items()}
    with pytest.raises(InputError, match=r"motor_current_alpha has only about 5000 Hz"):
        finding(Recording(late))


def test_a_low_supply_is_the_root_of_what_it_does_and_fills_one_code_of_the_memory(tmp_path):
    path, supply = tmp_path / "memory.json", np.where(LATE, 7.0, 13.0)
    found = finding(changed(supply_voltage=supply, motor_angle_mechanical=ANGLE + FIVE_DEGREES * LATE), memory=path)
    assert found.cause == "the supply of the controller is too low"
    assert "angle_alarm_from_s" in found.evidence
    memory = FaultMemory.opened(path, "motor-bench")
    raised = [name for name, entry in memory.entries.items() if entry.status & 0x08]
    assert raised == ["motor-supply-low"]


def test_pieces_give_what_the_whole_gives(monkeypatch):
    samples = changed(motor_angle_mechanical=ANGLE + FIVE_DEGREES * LATE)
    whole = finding(samples)
    monkeypatch.setattr("tierod.monitors.motor_angle.definition.SLICE", 7_777)
    pieces = finding(samples)
    assert (pieces.status, pieces.headline, pieces.since) == (whole.status, whole.headline, whole.since)
    assert pieces.evidence == pytest.approx(whole.evidence, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "cause", "code"),
    [
        ("stuck", "stands still", "motor-angle-stuck"),
        ("current phases b and c swapped", "contradict the model of the motor", "motor-currents"),
    ],
)
@pytest.mark.parametrize("begin", [3.0, 6.2])
def test_a_stalled_drive_has_the_right_root(tmp_path, name, cause, code, begin):
    fault = next(fault for fault in FAULTS if fault.name == name)
    diagnosis = diagnosed(drive(3, 8.0, fault, begin).samples, memory=tmp_path / "memory.json")
    assert cause in diagnosis.findings[0].cause
    memory = FaultMemory.opened(tmp_path / "memory.json", "motor-bench")
    raised = {each for each, entry in memory.entries.items() if entry.status & 0x08}
    assert code in raised
    assert not raised & ({"motor-angle-stuck", "motor-currents"} - {code})


def test_a_zero_that_leaps_beside_a_slow_motor_accuses_no_currents(tmp_path):
    """Its increments disturb the observer, while sine and cosine show at once whose fault it is."""
    slow = 50_000 + int(np.argmin(np.abs(drive(3, 8.0).speed[50_000:70_000])))
    leap = offset(12.0)
    samples = drive(3, 8.0, leap, slow / RATE).samples.copy()
    late = np.arange(len(samples)) >= slow
    true = 4.0 * (samples[:, COLUMN["motor_angle_mechanical"]] - np.where(late, leap.offset(np.zeros(1)), 0.0))
    jumped = finding(samples)
    assert math.degrees(jumped.estimate.value) == pytest.approx(12.0, abs=0.1)
    assert f"by a step of {estimated(jumped)} electrical" in said(jumped)
    assert jumped.since == pytest.approx(slow / RATE, abs=0.1)
    samples[:, COLUMN["resolver_sine"]], samples[:, COLUMN["resolver_cosine"]] = np.sin(true), np.cos(true)
    diagnosis = diagnosed(samples, memory=tmp_path / "memory.json")
    assert "sine and cosine" in diagnosis.findings[0].cause
    assert "model_alarm_from_s" in diagnosis.findings[0].evidence
    raised = FaultMemory.opened(tmp_path / "memory.json", "motor-bench").entries
    assert "motor-angle-mismatch" in {name for name, entry in raised.items() if entry.status & 0x08}
    assert not raised.get("motor-currents") or not raised["motor-currents"].status & 0x08


def test_what_the_user_got_wrong_fills_no_memory(tmp_path):
    path = tmp_path / "memory.json"
    diagnosed(changed(motor_angle_mechanical=4.0 * ANGLE), memory=path)
    memory = FaultMemory.opened(path, "motor-bench")
    assert not any(entry.status & 0x08 for entry in memory.entries.values())


def with_phases(samples, names="abc"):
    """A recording of phase currents in place of their vector."""
    channels = dict(recording(samples).channels)
    alpha, beta = channels.pop("motor_current_alpha"), channels.pop("motor_current_beta")
    across = 0.5 * math.sqrt(3.0) * beta.values
    values = {"a": alpha.values, "b": across - 0.5 * alpha.values, "c": -across - 0.5 * alpha.values}
    for name in names:
        channels[f"motor_current_{name}"] = Channel(f"motor_current_{name}", alpha.time, values[name], "A")
    return channels


@pytest.mark.parametrize("names", ["abc", "ab"])
def test_two_or_three_phase_currents_are_as_good_as_their_vector(names):
    found = finding(Recording(with_phases(FAULT_FREE().samples, names)), spread=False)
    assert found.status is Status.HEALTHY
    assert found.evidence == pytest.approx(finding(FAULT_FREE().samples).evidence, rel=1e-6)


def test_phase_currents_that_do_not_add_up_are_named():
    channels = with_phases(FAULT_FREE().samples)
    third = channels["motor_current_c"]
    channels["motor_current_c"] = replace(third, values=third.values + 5.0)
    found = finding(Recording(channels))
    assert found.cause == "the phase currents do not add up to zero"
