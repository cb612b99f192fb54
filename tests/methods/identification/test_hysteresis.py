from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from driven import lock_to_lock as virtual_turn
from shared_data import shared_data
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Recording
from tierod.io.readers import read
from tierod.methods.identification.hysteresis import HysteresisIdentification, friction_increase
from tierod.methods.identification.hysteresis_presence import HysteresisPresenceTest
from tierod.vehicles import load
from tierod_lab.ground import drive

METHOD = HysteresisIdentification.of_vehicle(load("midsize-eps"))
HEALTHY = 4.0


def changed(recording: Recording, **changes) -> Recording:
    """The recording with functions of (time, values) put through some of its channels."""
    channels = dict(recording.channels)
    for name, change in changes.items():
        time, values = change(channels[name].time, channels[name].values)
        channels[name] = dataclasses.replace(channels[name], time=time, values=values)
    return Recording(channels)


def turn(added=0.0, hoist=True, seed=1):
    return virtual_turn(HEALTHY + added, hoist, seed=seed)


@pytest.mark.parametrize("support", ["hoist", "ground"])
@pytest.mark.parametrize("added", [0.0, 8.5])
def test_added_friction_of_the_virtual_car_within_three_tenths(added, support):
    hoist = support == "hoist"
    fault_free, faulty = (METHOD.identify(turn(*each), support) for each in ((0.0, hoist, 1), (added, hoist, 2)))
    assert friction_increase(faulty, fault_free).value == pytest.approx(added, abs=0.3)
    if hoist:
        assert faulty.friction_torque == pytest.approx(HEALTHY + added, abs=0.1)
        assert math.degrees(faulty.pre_sliding.angle) == pytest.approx(1.0, abs=0.2)
    with pytest.raises(ParameterError, match="one support only"):
        friction_increase(faulty, dataclasses.replace(fault_free, support="lift"))


def test_damping_that_is_not_taken_off_shows_as_friction():
    with_damping, without = (
        each.identify(turn(), "hoist") for each in (METHOD, dataclasses.replace(METHOD, damping=0.0))
    )
    viscous = METHOD.damping * with_damping.mean_rate
    assert without.friction_torque - with_damping.friction_torque == pytest.approx(viscous, rel=1e-6)


def every(change):
    return dict.fromkeys(turn().names, change)


def holed(time, values):
    return time, np.where((time > 10.0) & (time < 11.0), np.nan, values)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"steering_wheel_angle": lambda t, v: (t, 0.3 * v)}, "deg, but a lock-to-lock loop needs"),
        (every(lambda t, v: (t[: 3 * len(t) // 4], v[: 3 * len(t) // 4])), "does not close"),
        ({"steering_wheel_rate": lambda t, v: (t, 9.0 * v)}, "in more than 3 s from lock to lock"),
        ({"vehicle_speed": lambda t, v: (t, np.full_like(v, 5.0))}, "the vehicle moves at up to 5.0 m/s"),
        (dict.fromkeys(("steering_wheel_angle", "steering_wheel_rate"), lambda t, v: (t, -v)), "turn the sign"),
        ({"driver_torque": holed}, "driver_torque is missing or stuck for 1.0 s within the test"),
        ({"steering_wheel_angle": lambda t, v: (t[::100], v[::100])}, "is sampled every 1 s"),
        ({"steering_wheel_angle": lambda t, v: (t, np.full_like(v, np.nan))}, "holds no values"),
    ],
)
def test_a_recording_that_is_no_lock_to_lock_test_is_refused(changes, sentence):
    with pytest.raises(InputError) as caught:
        METHOD.identify(changed(turn(), **changes), "hoist")
    assert sentence in str(caught.value)


NAMES = (
    "steering_wheel_angle",
    "steering_wheel_rate",
    "driver_torque",
    "motor_torque",
    "lateral_acceleration",
)


def outcome(recording, gain=1.0):
    aligned = recording.align(NAMES, 50.0)
    signals = dict(zip(NAMES, aligned.values.T, strict=True))
    signals["driver_torque"] = gain * signals["driver_torque"]
    return HysteresisPresenceTest().test(aligned.time, **signals)


@pytest.mark.parametrize(("friction", "present"), [(2.0, True), (1e-3, False)])
def test_friction_is_noticed_in_two_minutes_whatever_the_unit_of_the_torque(friction, present):
    found = outcome(drive(minutes=2.0, friction=friction, seed=3), gain=250.0)
    assert found.present == present, found


def test_the_highway_minute_carries_hysteresis():
    log = shared_data("rav4_highway_minute", "can.log")
    found = outcome(read(log, dbc="rav4", channel_map="rav4", names=NAMES))
    assert found.present
    assert found.share == pytest.approx(0.2, abs=0.05)
