import math

import numpy as np
import pytest

from tierod.monitors.motor_angle.detector import MotorAngleSample
from tierod.studies.claims import Claim
from tierod.studies.content import Table
from tierod.studies.motor_angle.fault_drives import FAULTS, FIVE_DEGREES, RATE, drive
from tierod.studies.motor_angle.sensor_faults import delays_of_fault, false_alarms, items
from tierod.studies.registry import Effort

BY_NAME = {fault.name: fault for fault in FAULTS}
ANGLE = MotorAngleSample._fields.index("motor_angle_mechanical")


def test_a_fault_changes_nothing_before_it_begins_and_then_what_it_says():
    sound, faulty = drive(1, 0.6), drive(1, 0.6, BY_NAME["offset of 5° electrical"], 0.5)
    np.testing.assert_array_equal(sound.samples[:5000], faulty.samples[:5000])
    jump = faulty.samples[5000, ANGLE] - sound.samples[5000, ANGLE]
    assert jump == pytest.approx(FIVE_DEGREES)
    assert pytest.approx(math.radians(5.0) / 4.0) == FIVE_DEGREES


def test_a_stuck_sensor_reads_what_it_read_last():
    faulty = drive(1, 0.6, BY_NAME["stuck"], 0.5)
    late = faulty.samples[5000:, ANGLE]
    assert late.std() < 6e-4
    assert late.mean() == pytest.approx(faulty.samples[4999, ANGLE], abs=0.003)


def test_delays_count_from_when_a_drift_is_as_large_as_five_degrees():
    drift = BY_NAME["drift of 20°/s electrical"]
    assert drift.offset(np.array([drift.size]))[0] == pytest.approx(FIVE_DEGREES)
    delays = delays_of_fault(BY_NAME["offset of 5° electrical"], 2)
    assert delays.found == 2
    assert (delays.turning <= delays.values + 1e-9).all()


def test_sound_drives_are_counted_in_hours():
    sound = false_alarms(1, seconds=7.0)
    assert sound.hours == pytest.approx(7.0 / 3600.0)
    assert 0.0 < sound.turning < 2.0 / 3600.0
    assert sound.alarms == 0


@pytest.mark.slow
def test_the_study_meets_what_it_claims_but_for_reversals():
    told = list(items(Effort()))
    table = next(item for item in told if isinstance(item, Table))
    assert all(row[1] == "40 of 40" for row in table.rows)
    claims = {item.id: item for item in told if isinstance(item, Claim)}
    for name in ("offset-median", "offset-turning", "drift-turning", "stalling", "none-false"):
        claim = claims[f"faults.{name}"]
        assert claim.goal.holds(claim.measured), claim.id


def test_times_are_in_samples_of_the_modulation():
    assert RATE == 1e4
    assert len(drive(1, 0.2).samples) == 2000
