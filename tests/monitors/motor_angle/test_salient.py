"""Motors with different inductances along and across the flux, and loads that step within one sample."""

import math
import re
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, finding, vehicle_with
from said import said
from tierod.core.findings import Status
from tierod_lab.papers.motor_angle.fault_trials import fast_drive, salient_drive, salient_monitor

driven = lru_cache(maxsize=8)(salient_drive)
"""Drives that several tests watch; one that changes the samples changes a copy."""

RATIOS = (1.1, pytest.param(2.0, marks=pytest.mark.slow), 3.0)


def along(ratio):
    return salient_monitor(ratio).observer.parameters.motor_inductance


def car(along, ratio=None):
    vehicle = vehicle_with(motor_inductance=along)
    if ratio is None:
        return vehicle
    saliency = replace(vehicle.parameters["motor_inductance"], name="motor_saliency", value=ratio, unit="")
    return replace(vehicle, parameters={**vehicle.parameters, "motor_saliency": saliency})


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_fault_free_drive_is_healthy_and_an_offset_is_a_fault_of_the_sensor(ratio):
    samples = driven(ratio, 6, 9.0).samples.copy()
    assert finding(samples, car(along(ratio), ratio)).status is Status.HEALTHY
    samples[62_000:, COLUMN["motor_angle_mechanical"]] += np.radians(5.0) / 4.0
    found = finding(samples, car(along(ratio), ratio))
    assert found.status is Status.FAULT
    assert "angle sensor differs" in found.cause
    assert math.degrees(found.estimate.value) == pytest.approx(5.0, abs=1.0)


@pytest.mark.parametrize("ratio", [1.5, 3.0])
def test_a_saliency_that_the_file_does_not_know_is_named_and_is_no_fault(ratio):
    found = finding(driven(ratio, 5, 12.0).samples, car(along(ratio)))
    assert found.status is Status.NOT_TESTABLE
    assert "those along and across the flux may differ" in found.cause
    assert f"across the flux is {ratio:.1f}" in found.cause
    assert float(found.action.split("motor_saliency = ")[1].split()[0]) == pytest.approx(ratio, rel=0.05)


@pytest.mark.parametrize("ratio", [2.0, pytest.param(3.0, marks=pytest.mark.slow)])
def test_field_weakening_with_the_inductance_across_the_flux_alone_names_the_one_along_it(ratio):
    drive = fast_drive(ratio, 52, 9.0).samples
    found = finding(drive, car(ratio * along(ratio)))
    assert found.status is Status.NOT_TESTABLE
    assert f"the inductance along the flux is {1.0 / ratio:.1f}" in found.cause
    assert "1.00 times" not in said(found)
    given = re.fullmatch(r"give motor_inductance = (\S+) H .* motor_saliency = (\S+) .*", found.action)
    assert finding(drive, car(*map(float, given.groups()))).status is Status.HEALTHY
