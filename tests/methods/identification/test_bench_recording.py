import math
from dataclasses import replace

import numpy as np
import pytest

from methods.identification.bench import FREE, LOCKED, RAMPS, SINES, TRUTH, changed, recordings, retimed, row, turned
from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.methods.identification.column_fit import FRICTION, search_of
from tierod.methods.identification.column_misfit import refuse_slips


@pytest.mark.parametrize(("name", "locked"), [(FREE, False), (LOCKED, True), (RAMPS, True), (SINES, False)])
def test_it_sees_whether_the_wheel_is_locked_and_how_noisy_the_sensors_are(name, locked):
    found = row(name)
    assert found.locked is locked
    assert found.sample_time == pytest.approx(1e-3)
    assert found.deviation == pytest.approx((math.radians(0.05), math.radians(0.2), 0.02), rel=0.1)
    assert found.remarks == ()


def test_missing_channels_are_named_with_what_is_needed():
    channels = dict(recordings()[FREE].channels)
    del channels["motor_torque"], channels["driver_torque"]
    with pytest.raises(InputError, match=r"lacks driver_torque and motor_torque.*channel map"):
        row(FREE, Recording(channels))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"motor_torque": lambda t, v: (t, np.full_like(v, 0.1))}, "'motor_torque' is constant at 0.1"),
        ({"driver_torque": lambda t, v: (t, np.full_like(v, 0.5))}, "'driver_torque' is constant"),
        ({"motor_angle_mechanical": lambda t, v: (t, v * 1e-6 + 1e-3 * np.cos(t * 7e3))}, "does not excite"),
        ({"motor_torque": lambda t, v: (t[::10], v[::10])}, "10 ms apart; a column swings"),
        ({"motor_torque": lambda t, v: (1e3 * t, v)}, "in milliseconds"),
        ({"driver_torque": lambda t, v: (t[:1500], v[:1500])}, "holds 1.5 s"),
        ({"motor_torque": lambda t, v: (t, np.where((t > 1.0) & (t < 2.0), np.nan, v))}, "is missing in"),
        ({"driver_torque": lambda t, v: (t, np.where(t > 0.2, np.nan, v))}, "'driver_torque' is missing in 9"),
        ({"steering_wheel_angle": lambda t, v: (t, np.full_like(v, np.nan))}, "is missing in 100 %"),
    ],
)
def test_recordings_that_cannot_be_used(change, words):
    with pytest.raises(InputError, match=words):
        row(FREE, changed(recordings()[FREE], **change))


def test_a_channel_with_every_second_sample_shows_noise_and_first_state_all_the_same():
    whole = changed(recordings()[SINES], motor_angle_mechanical=lambda t, v: (t, v + 5.0))
    half = changed(whole, motor_angle_mechanical=lambda t, v: (t, np.where(np.arange(len(v)) % 2 > 0, np.nan, v)))
    found, right = row(SINES, half), row(SINES, whole)
    assert found.deviation == pytest.approx(right.deviation, rel=0.1)
    np.testing.assert_allclose(found.experiment.initial_mean[4], right.experiment.initial_mean[4], atol=5e-3)


def test_a_sensor_at_its_limit_is_taken_as_missing_there():
    clipped = changed(recordings()[LOCKED], driver_torque=lambda t, v: (t, np.clip(v, -3.0, 3.0)))
    found = row(LOCKED, clipped)
    assert "'driver_torque' stays at its largest value" in found.remarks[0]
    measured = found.experiment.measured[:, 2]
    assert np.isnan(measured).sum() > 100
    assert np.nanmax(np.abs(measured)) <= 3.0


@pytest.mark.parametrize("name", [FREE, RAMPS])
@pytest.mark.parametrize("channels", [("motor_torque",), ("motor_angle_mechanical",), ("driver_torque",)])
def test_a_sign_the_wrong_way_round_is_named(name, channels):
    wrong = row(name, turned(recordings()[name], *channels))
    with pytest.raises(InputError, match=rf"{name}: the sign of {channels[0]} cannot be right"):
        refuse_slips(wrong, search_of(TRUTH, FRICTION, [wrong], widened=True))


def test_a_wrong_sign_of_the_wheel_is_named():
    wrong = row(FREE, turned(recordings()[FREE], "steering_wheel_angle"))
    with pytest.raises(InputError, match="the sign of steering_wheel_angle cannot be right"):
        refuse_slips(wrong, search_of(TRUTH, FRICTION, [wrong], widened=True))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_wrong_time_base_is_named(factor):
    wrong = row(FREE, retimed(recordings(6.0)[FREE], factor))
    with pytest.raises(InputError, match="the time base cannot be right"):
        refuse_slips(wrong, search_of(TRUTH, FRICTION, [wrong], widened=True))


@pytest.mark.parametrize("name", [FREE, LOCKED, RAMPS, SINES])
@pytest.mark.parametrize("factor", [0.6, 1.0, 1.6])
def test_a_fault_free_recording_passes_also_with_rough_parameters(name, factor):
    rough = replace(TRUTH, motor_friction=TRUTH.motor_friction * factor, motor_damping=TRUTH.motor_damping / factor)
    found = row(name)
    refuse_slips(found, search_of(rough, FRICTION, [found], widened=True))


def test_a_torque_in_coarse_steps_is_remarked():
    coarse = changed(recordings()[RAMPS], motor_torque=lambda t, v: (t, np.round(v, 2)))
    assert "is quantised in steps of 0.01 N·m, 10 % of the motor's friction" in row(RAMPS, coarse).remarks[0]
