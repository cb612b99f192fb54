import numpy as np
import pytest

from tierod.core.graph import scan
from tierod_lab.papers.condition.rules.adaptive_speed import AdaptiveSpeed

BLOCK = AdaptiveSpeed.design(1.084, 0.01)
TIME = np.arange(3000) * 0.01


def drive(offset=0.05):
    random = np.random.default_rng(5)
    speed = 8.0 + 2.0 * np.sin(0.4 * TIME)
    yaw = 0.4 * np.sin(0.6 * TIME)
    along = 0.8 * np.cos(0.4 * TIME) + offset
    left, right = speed - 0.542 * yaw, speed + 0.542 * yaw
    columns = np.stack([along, yaw, 0.0 * yaw, left, right], axis=1)
    columns += random.normal(size=columns.shape) * [0.1, 0.003, 0.0, 0.02, 0.02]
    return speed, columns


def error(speed, columns, start=300):
    return float(np.sqrt(np.mean((scan(BLOCK, columns)["forward_speed"] - speed)[start:] ** 2)))


def test_it_follows_both_wheels_to_millimetres_per_second():
    assert error(*drive()) < 0.01


@pytest.mark.parametrize("column", [3, 4])
@pytest.mark.parametrize("kind", ["lost", "offset"])
def test_a_wheel_that_fails_for_twenty_seconds_hardly_moves_it(column, kind):
    speed, columns = drive()
    columns[1000:, column] = 0.0 if kind == "lost" else columns[1000:, column] + 2.0
    assert error(speed, columns, 1000) < 0.03


def test_the_offset_of_the_accelerometer_is_found_in_the_end():
    _, columns = drive(offset=0.3)
    found = scan(BLOCK, np.tile(columns, (6, 1)))["offset"][-1]
    assert found == pytest.approx(0.3, abs=0.1)


def test_after_a_long_gap_it_starts_anew():
    speed, columns = drive()
    columns[1000:1600] = np.nan
    assert error(speed, columns, 1620) < 0.03


def test_where_both_wheels_agree_on_another_speed_it_gives_in():
    speed, columns = drive()
    jumped = speed + np.where(np.arange(len(speed)) >= 1500, 3.0, 0.0)
    columns[1500:, 3:] += 3.0
    assert error(jumped, columns, 1650) < 0.05


def test_it_starts_at_the_speed_of_the_wheels():
    speed, columns = drive()
    assert scan(BLOCK, columns[:20])["forward_speed"][-1] == pytest.approx(speed[19], abs=0.1)
