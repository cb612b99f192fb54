"""The grid that suits a recording."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.monitors.driver_torque.definition import DRIVER_TORQUE
from tierod.monitors.friction.definition import FRICTION


def recording(**rates):
    """Channels of these names and rates [Hz]."""
    times = {name: np.arange(0.0, 10.0, 1.0 / rate) for name, rate in rates.items()}
    return Recording({name: Channel(name, time, np.sin(time), "") for name, time in times.items()})


@pytest.mark.parametrize(
    ("angle", "torque", "grid"),
    [
        (1000.0, 1000.0, 1000.0),
        (2000.0, 980.0, 1000.0),
        (1000.0, 250.0, 200.0),
        (100.0, 1000.0, 100.0),
        (20.0, 20.0, 50.0),
    ],
)
def test_it_is_as_fast_as_the_slowest_channel_that_is_needed(angle, torque, grid):
    made = recording(steering_wheel_angle=angle, driver_torque=torque, motor_torque=10.0)
    assert DRIVER_TORQUE.suited_to(made).rate == grid


def test_a_monitor_that_names_no_slower_rates_keeps_its_own():
    assert FRICTION.suited_to(recording(yaw_rate=25.0)) == FRICTION


def test_a_recording_without_the_channels_changes_nothing():
    assert DRIVER_TORQUE.suited_to(recording(yaw_rate=25.0)).rate == DRIVER_TORQUE.rate
    assert replace(DRIVER_TORQUE) == DRIVER_TORQUE
