import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.graph import scan
from tierod_lab.papers.condition import two_bodies as part
from tierod_lab.papers.condition.rules.angle_filters import one_body, two_bodies
from tierod_lab.papers.condition.rules.residual_set import residual_set

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")


def test_the_modes_are_those_of_table_a1():
    found = part.modes()
    assert found[:2].real == pytest.approx([-1.45, -22.4], abs=0.05)
    assert sorted(found[2:].imag) == pytest.approx([-4187.0, 4187.0], abs=1.0)
    assert found[2:].real == pytest.approx([-3966.0] * 2, abs=1.0)


@pytest.mark.slow
def test_explicit_sampling_shows_as_diverging_and_no_other():
    rows = {each.name: each for each in part.sampled(0.1)}
    assert {name for name, each in rows.items() if not np.isfinite(each.error)} == {
        "two bodies, ten steps of Euler",
        "two bodies, 20 steps of Runge and Kutta",
    }
    assert rows["two bodies, 50 steps of Runge and Kutta"].error < 1e-6
    assert rows["two bodies, 20 steps of Runge and Kutta"].row[-1] == "diverges"
    once, anew = (rows[f"two bodies, exponential {way}"] for way in ("of eq (3), friction explicit", "in every state"))
    assert once.multiplications < anew.multiplications / 20


def test_both_filters_find_the_same_angle_and_a_copy_halves_the_variance():
    random = np.random.default_rng(4)
    time = np.arange(400) * 0.01
    angle = 0.3 * np.sin(time) + 0.002 * random.normal(size=400)
    inputs = [2.0 * np.cos(time), 50.0 * np.sin(time)]
    single = scan(one_body(CAR), np.stack([*inputs, angle], axis=1))
    pair = two_bodies(CAR)
    once = scan(pair, np.stack([*inputs, np.full(400, np.nan), angle], axis=1))
    twice = scan(pair, np.stack([*inputs, CAR.rack_ratio * angle, angle], axis=1))
    name = "steering_wheel_angle"
    assert once[f"mean.{name}"][50:] == pytest.approx(single[f"mean.{name}"][50:], abs=2e-3)
    assert once["mean.rack_position"][50:] == pytest.approx(CAR.rack_ratio * once[f"mean.{name}"][50:], abs=2e-5)
    ratio = twice[f"variance.{name}"][-1] / once[f"variance.{name}"][-1]
    assert 0.5 < ratio < 0.7


@pytest.mark.parametrize("copied", [pytest.param(False, marks=pytest.mark.slow), True])
def test_the_residuals_take_the_filter_of_two_bodies(copied):
    lost = circle(steering_wheel_angle=0.2)
    lost[300:, 3] = 0.0
    names = [f"residuals.{name}" for name in ("r1", "r2", "r3")]
    pair = scan(residual_set(CAR, angle=two_bodies(CAR), copied=copied), lost)
    single = scan(residual_set(CAR), lost)
    assert pair[names[0]][290] == pytest.approx(single[names[0]][290], abs=1e-3)
    assert pair[names[0]][300] > 0.03  # a jump
    assert all((pair[name] == single[name]).all() for name in names[1:])
