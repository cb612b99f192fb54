import numpy as np
import pytest

from tierod.core.graph import scan
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.papers.friction.plant_checks import courses
from tierod_lab.papers.friction.plant_replay import Replay


@pytest.mark.parametrize("chassis", [SingleTrack(), TwoTrack()], ids=["single", "two"])
def test_the_recorded_speed_is_kept(chassis):
    time = np.arange(8000) * 1e-3
    speed = 15.0 + 3.0 * np.sin(0.5 * time)
    out = scan(Replay(chassis, start_speed=15.0), courses(0.02 * np.sin(time), speed))
    assert np.max(np.abs(out["speed"] - speed)[200:]) < 0.12
    assert np.max(out["yaw_rate"]) > 0.05


def test_it_begins_straight_ahead_at_its_speed():
    first = scan(Replay(start_speed=12.0), courses(np.zeros(5), 12.0)).at(0)
    assert first.speed == 12.0
    assert first.yaw_rate == first.lateral_speed == 0.0
    assert first.wheel_speeds.rear_left == pytest.approx(12.0)
