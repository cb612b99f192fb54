import numpy as np
import pytest

from tierod_lab.papers.motor_angle import temperature
from tierod_lab.papers.motor_angle.drawn_motors import Errors, drawn, ramped
from tierod_lab.papers.motor_angle.observer_drives import to_and_fro
from tierod_lab.papers.motor_angle.temperature import COLD, HOT, RAMP, ZERO, alarmed, judged, ramp


def test_a_hot_motor_is_learnt():
    found = judged("hot", HOT, [to_and_fro(900, 10.0, ZERO + HOT)])
    assert found.resistance == pytest.approx(1.39, abs=0.01)
    assert found.learnt_resistance == pytest.approx(found.resistance, rel=0.05)
    assert found.learnt_flux == pytest.approx(found.flux, rel=0.02)
    assert found.rms < 0.006
    assert found.alarms == 0


def test_a_ramp_warms_the_motor_through_the_whole_range(monkeypatch):
    """In half the time of the study, so twice as fast."""
    monkeypatch.setattr(temperature, "RAMP", 0.5 * RAMP)
    seen = ramp(900, COLD, HOT)
    found = judged("ramp", HOT, [seen])
    assert seen.time[-1] == pytest.approx(0.5 * RAMP, abs=0.01)
    assert found.learnt_resistance == pytest.approx(1.39, rel=0.05)
    assert not alarmed(seen)


def test_a_sensor_that_leaps_would_be_seen():
    seen = to_and_fro(900, 10.0, ZERO + HOT)
    samples = seen.samples.copy()
    samples[70_000:, 4] += 0.2
    assert alarmed(type(seen)(**{**vars(seen), "samples": samples}))


def test_motors_that_differ_are_followed():
    for found in (drawn(650), ramped(650)):
        assert isinstance(found, Errors)
        assert 0.0 < found.rms < 0.01
        assert np.isfinite(found.most)
