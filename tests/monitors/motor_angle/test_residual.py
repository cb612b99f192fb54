import numpy as np
import pytest

from monitors.motor_angle.monitored import columns
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.motor_angle.comparison import ResidualGate

GATE = ResidualGate(4.0, 0.0085, start=0.1)


def counted(speed=20.0, deviation=0.005, flux=0.0085, standing=0.0, angle=1.0, samples=3000):
    seen = {
        "motor_angle_mechanical": angle,
        "motor_speed": speed,
        "motor_angle_standard_deviation": deviation,
        "motor_flux": flux,
        "standing": standing,
    }
    return scan(GATE, columns(GATE, samples, **seen))


def test_it_counts_one_value_in_a_millisecond_after_start_and_hold():
    found = counted()
    first = int(np.argmax(found["counts"]))
    assert first in range(1190, 1202)
    assert found["counts"].sum() == pytest.approx((3000 - first) / 10, abs=1)


@pytest.mark.parametrize(
    "away", [{"speed": 9.9}, {"deviation": 0.04}, {"flux": 0.006}, {"standing": 1.0}, {"angle": np.nan}]
)
def test_nothing_counts_where_the_currents_tell_no_angle(away):
    assert counted(**away)["counts"].sum() == 0.0


def test_an_interruption_begins_the_hold_anew():
    speed = np.full(3000, -20.0)
    speed[2000] = 0.0
    known = counted(speed=speed)["known"]
    assert known[1999] == 1.0
    assert known[2000:2190].max() == 0.0
    assert known[2210:].min() == 1.0


def test_readings_in_every_tenth_sample_count_all():
    angle = np.where(np.arange(3000) % 10 == 3, 1.0, np.nan)
    assert counted(angle=angle)["counts"].sum() == pytest.approx(180, abs=1)


def test_a_gate_that_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="spacing"):
        ResidualGate(4.0, 0.0085, spacing=0.0)
