"""Fault-free drives recorded wrongly from beginning to end: each is named, with its cure."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, finding, recording, redrawn
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.balance import AS_RECORDED, Balance
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.bench import bench, course, observed_drive

P = load("motor-bench").parameters_for(SampledMotorParameters)
CURRENTS, VOLTAGES = "motor_current", "motor_voltage"
TURN = np.exp(2j * np.pi / 3.0)
CASES = {
    "sign of the currents": (CURRENTS, lambda v: -v, "the currents have the wrong sign", "factor of -1"),
    "sign of the voltages": (VOLTAGES, lambda v: -v, "the voltages have the wrong sign", "factor of -1"),
    "phases b and c": (CURRENTS, np.conj, "the phases of the currents are swapped: b and c", "channel map"),
    "phases a and b": (CURRENTS, lambda v: TURN * np.conj(v), "currents are swapped: a and b", "channel map"),
    "phases a and c": (CURRENTS, lambda v: np.conj(v) / TURN, "currents are swapped: a and c", "channel map"),
    "alpha and beta": (CURRENTS, lambda v: 1j * np.conj(v), "currents are swapped: alpha and beta", "alpha and beta"),
    "their voltages": (VOLTAGES, lambda v: 1j * np.conj(v), "voltages are swapped: alpha and beta", "alpha and beta"),
    "phases of the voltages": (VOLTAGES, np.conj, "the phases of the voltages are swapped", "channel map"),
    "phases moved on": (CURRENTS, lambda v: TURN * v, "the phases of the currents are in the wrong order", "order"),
    "voltages moved on": (VOLTAGES, lambda v: TURN * v, "the phases of the voltages are in the wrong order", "order"),
    "power-invariant currents": (CURRENTS, lambda v: 1.5**0.5 * v, "the recorded currents are 1.2 times", "amplitude"),
    "half the voltage": (VOLTAGES, lambda v: 0.5 * v, "so are the recorded voltages", "factor and unit"),
}


REPEATED = ("phases a and c", "voltages moved on")
"""Those like another: which pair is swapped, and which of the two is moved on, is one and the same search."""


@pytest.mark.parametrize(
    "case", [pytest.param(each, marks=pytest.mark.slow) if each in REPEATED else each for each in CASES]
)
def test_it_is_named_with_its_cure(case):
    name, change, cause, action = CASES[case]
    found = finding(redrawn(FAULT_FREE().samples, name, change))
    assert found.status is Status.NOT_TESTABLE
    assert cause in found.cause
    assert action in found.action


def _finer(samples):
    """A drive sampled twice as often: between two samples everything goes on evenly."""
    at = np.arange(0.0, len(samples) - 1.0, 0.5)
    fine = np.column_stack([np.interp(at, np.arange(len(samples)), column) for column in samples.T])
    fine[:, 2:4] = samples[np.ceil(at).astype(int), 2:4]
    return fine


@pytest.mark.parametrize(("times", "result"), [(0.5, "every 0.2 ms"), (2.0, "every 0.05 ms")])
def test_a_wrong_sampling_time_is_named_with_the_right_one(times, result):
    """Samples that came every 0.2 ms and are stated to come every 0.1 ms, and the other way round."""
    channels = recording(FAULT_FREE().samples if times < 1.0 else _finer(FAULT_FREE().samples)).channels
    scaled = {name: replace(each, time=min(times, 1.0) * each.time) for name, each in channels.items()}
    found = finding(Recording(scaled))
    assert found.status is Status.NOT_TESTABLE
    assert f"the samples come {result}, but by their time stamps every 0.1 ms" in found.cause
    assert "unit or its sampling interval" in found.action


def balance(values=(1.0, 1.0, 1.0), direction=0.0, reading=AS_RECORDED, change=7.0):
    resistance, inductance, flux = values
    return Balance(
        reading,
        resistance * P.motor_resistance,
        inductance * P.motor_inductance,
        flux * P.motor_flux,
        direction,
        unexplained=0.01,
        windows=500,
        change=change,
        turn=0.7,
    )


@pytest.mark.parametrize("share", [0.1, 0.03, 0.0])
def test_a_drive_too_slow_to_be_judged_is_not_called_wrong(share):
    """The noise of the current makes its inductance seem small."""
    time = np.arange(7000) * 1e-3
    slow = observed_drive(bench(), share * course(time, 7), np.zeros(len(time)), 7)
    samples = np.full((len(slow.angle), len(COLUMN)), np.nan)
    samples[:, :5] = slow.samples
    assert finding(samples).status is Status.NOT_ENABLED
