"""The grid that suits a recording."""

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.monitors.driver_torque.definition import DRIVER_TORQUE


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
