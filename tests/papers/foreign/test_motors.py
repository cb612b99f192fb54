import re

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.core.findings import Finding, Status
from tierod_lab.papers.foreign.motor_drives import MACHINES, SAMPLE_TIME, motor_drive
from tierod_lab.papers.foreign.motors import FAULTS, Judged, alarms_of, judged, shown, vehicle

FALSE = Finding("motor-angle", Status.FAULT, "False.", 1.0, cause="none", action="none")


class Outputs(dict):
    @property
    def names(self):
        return tuple(self)


def test_alarms_are_timed_from_where_they_count():
    flags = np.zeros(1000)
    flags[700:] = 1.0
    outputs = Outputs({"alarms.following": flags, "alarms.rate": np.zeros(1000), "compared.known": np.ones(1000)})
    during = np.arange(1000) >= 500
    assert alarms_of(outputs, during) == {"following": pytest.approx(200 * SAMPLE_TIME)}
    assert alarms_of(outputs, np.arange(1000) >= 1001) == {}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_begins_when_it_should(fault):
    time = np.arange(2000) * SAMPLE_TIME
    angle = 20.0 * time
    read = FAULTS[fault](angle, time - 0.1, 4.0)
    assert np.array_equal(read[:1000], angle[:1000])
    assert abs(read[-1] - angle[-1]) > 0.005


def test_false_alarms_come_first_and_are_counted():
    quiet = Judged("one", 5.0, 0.01, (), dict.fromkeys(FAULTS, 0.1))
    loud = Judged("other", 5.0, 0.2, ("rate",), dict.fromkeys(FAULTS, np.inf), FALSE)
    found = list(shown([quiet, loud]))
    (table,) = (each for each in found if isinstance(each, Table))
    assert [row[0] for row in table.rows] == ["other", "one"]
    claims = {each.id: each for each in found if isinstance(each, Claim)}
    assert claims["motors.false-alarms"].measured == 1.0
    assert claims["motors.faults-found"].measured == 0.5
    assert claims["motors.without-saliency"].measured == 1.0
    assert not any(each.met for each in claims.values())


def test_the_vehicle_file_has_the_machines_parameters():
    made = vehicle("48 V, interior magnets")
    assert made.parameters["motor_saliency"].value == pytest.approx(2.0)
    assert "motor_saliency" not in vehicle("48 V, interior magnets", salient=False).parameters
    assert made.parameters["motor_flux"].value == MACHINES["48 V, interior magnets"].flux


@pytest.mark.slow
def test_a_drive_of_motulator_obeys_the_voltage_equation():
    """u = R i + d(psi)/dt over the samples, with the machine's own parameters: the voltage is that of its sample."""
    pytest.importorskip("motulator")
    name = "12 V, surface magnets"
    machine, drive = MACHINES[name], motor_drive(name, 3, 2.0)
    current = drive.samples[:, 0] + 1j * drive.samples[:, 1]
    voltage = drive.samples[:, 2] + 1j * drive.samples[:, 3]
    flux = machine.direct * current + machine.flux * np.exp(1j * machine.pole_pairs * drive.angle)
    lengths = 200
    left = np.add.reduceat(voltage[1:], np.arange(0, len(voltage) - lengths, lengths))[:-1] * SAMPLE_TIME
    starts = np.arange(0, len(voltage) - lengths, lengths)[:-1]
    mean = 0.5 * (current[1:] + current[:-1])
    drop = np.add.reduceat(mean, np.arange(0, len(voltage) - lengths, lengths))[:-1] * SAMPLE_TIME * machine.resistance
    rest = left - drop - (flux[starts + lengths] - flux[starts])
    assert np.abs(rest).max() < 0.1 * np.abs(left).max()


@pytest.mark.slow
def test_a_machine_of_the_home_rating_is_judged_rightly():
    pytest.importorskip("motulator")
    found = judged(("12 V, surface magnets", 5, 8.0))
    assert found.false == ()
    assert found.delays["offset of 0.3 rad electrical"] < 0.5


@pytest.mark.slow
def test_a_machine_whose_saliency_the_file_lacks_is_not_accused():
    pytest.importorskip("motulator")
    found = judged(("48 V, interior magnets", 5, 8.0))
    assert found.plain.status is Status.NOT_TESTABLE
    advised = re.search(r"motor_saliency = ([\d.]+)", found.plain.action)
    assert advised is not None
    assert float(advised[1]) == pytest.approx(2.0, rel=0.02)
