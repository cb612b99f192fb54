"""Datasets of the study of foreign plants in a small size."""

import re

import numpy as np
import pytest

from tierod.core.findings import Status
from tierod.monitors.diagnose import diagnose
from tierod_lab.papers.foreign import datasets
from tierod_lab.papers.foreign.datasets import FAULTS, first_alarm, machine_file, over_column, over_motors
from tierod_lab.papers.foreign.motor_drives import MACHINES, SAMPLE_TIME, motor_drive
from tierod_lab.papers.foreign.multibody_car import RATE, multibody_drive
from tierod_lab.papers.foreign.rubbing_column import LUGRE


class Outputs(dict):
    @property
    def names(self):
        return tuple(self)


def test_alarms_are_timed_from_where_they_count():
    flags = np.zeros(1000)
    flags[700:] = 1.0
    outputs = Outputs({"alarms.following": flags, "alarms.rate": np.zeros(1000), "compared.known": np.ones(1000)})
    during = np.arange(1000) >= 500
    assert first_alarm(outputs, during) == pytest.approx(200 * SAMPLE_TIME)
    assert first_alarm(outputs, np.arange(1000) >= 1001) == np.inf


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_begins_when_it_should(fault):
    time = np.arange(2000) * SAMPLE_TIME
    angle = 20.0 * time
    read = FAULTS[fault](angle, time - 0.1, 4.0)
    assert np.array_equal(read[:1000], angle[:1000])
    assert abs(read[-1] - angle[-1]) > 0.005


def test_the_multibody_car_turns_to_the_left_where_it_says_so():
    pytest.importorskip("vehiclemodels")
    seen = multibody_drive(3, 12.0)
    values = {name: each.values for name, each in seen.channels.items()}
    assert np.corrcoef(values["steering_wheel_angle"], values["yaw_rate"])[0, 1] > 0.9
    faster = values["wheel_speed_rear_right"] - values["wheel_speed_rear_left"]
    assert np.corrcoef(faster, values["yaw_rate"])[0, 1] > 0.9
    assert len(values["yaw_rate"]) == round(12.0 * RATE)


@pytest.mark.slow
def test_a_foreign_column_is_judged_against_its_own_truth():
    rows = over_column((LUGRE, 0, 5, 3.0))
    assert [row["level"] for row in rows] == [4.0, 5.5, 8.0, 12.5]
    assert sum(row["wrong"] for row in rows) == 0.0
    assert max(abs(row["error"]) for row in rows) < 1.5


@pytest.mark.slow
def test_a_machine_of_the_home_rating_is_judged_rightly():
    pytest.importorskip("motulator")
    free, *faults = over_motors(("12 V, surface magnets", 5, 8.0))
    assert free["alarmed"] == 0.0
    assert {row["fault"]: row["delay"] for row in faults}["offset of 0.3 rad electrical"] < 0.5


@pytest.mark.slow
def test_a_machine_whose_saliency_the_file_lacks_is_not_accused():
    pytest.importorskip("motulator")
    name = "48 V, interior magnets"
    recording = datasets.recorded(motor_drive(name, 5, 8.0))
    plain = diagnose(recording, machine_file(name, salient=False), "motor-angle", spread=False).findings[0]
    assert plain.status is Status.NOT_TESTABLE
    advised = re.search(r"motor_saliency = ([\d.]+)", plain.action)
    assert advised is not None
    assert float(advised[1]) == pytest.approx(2.0, rel=0.02)


@pytest.mark.slow
def test_a_drive_of_motulator_obeys_the_voltage_equation():
    """u = R i + d(psi)/dt over the samples, with the machine's own parameters: the voltage is that of its sample."""
    pytest.importorskip("motulator")
    name = "12 V, surface magnets"
    machine, drive = MACHINES[name], motor_drive(name, 3, 2.0)
    current = drive.samples[:, 0] + 1j * drive.samples[:, 1]
    voltage = drive.samples[:, 2] + 1j * drive.samples[:, 3]
    flux = machine.direct * current + machine.flux * np.exp(1j * machine.pole_pairs * drive.angle)
    starts = np.arange(0, len(voltage) - 200, 200)
    left = np.add.reduceat(voltage[1:], starts)[:-1] * SAMPLE_TIME
    drop = np.add.reduceat(0.5 * (current[1:] + current[:-1]), starts)[:-1] * SAMPLE_TIME * machine.resistance
    rest = left - drop - (flux[starts[:-1] + 200] - flux[starts[:-1]])
    assert np.abs(rest).max() < 0.1 * np.abs(left).max()
