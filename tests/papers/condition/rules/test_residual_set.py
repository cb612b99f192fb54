from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from monitors.condition.demonstrator import CAR, circle
from tierod.core.graph import scan
from tierod.monitors.condition.signals import ConditionSample
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, SENSOR_RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.rack import StiffRack, discretise_pair
from tierod_lab.papers.condition.rules.residual_set import residual_set

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

BLOCK = residual_set(CAR)
ROLLING = ("r2", "r7", "r8", "r9", "r10", "r11", "r12", "r13", "r14", "r15")


def last(samples, block=BLOCK):
    result = scan(block, samples)
    return {each.name: result[f"residuals.{each.name}"][-1] for each in SENSOR_RESIDUALS}


def test_rolling_on_a_circle_leaves_no_residual():
    residuals = last(circle())
    for name in ROLLING:
        assert residuals[name] == pytest.approx(0.0, abs=2e-3), name
    for name in ("r5", "r16"):  # the tyres slip a little in the single track
        assert residuals[name] == pytest.approx(0.0, abs=0.03), name


def test_a_lost_wheel_is_seen_by_the_means_of_both_and_by_its_own_filter_alone():
    samples = circle(seconds=8.0)
    samples[400:, ConditionSample._fields.index("wheel_speed_rear_right")] = 0.0
    residuals = last(samples)
    assert residuals["r14"] == pytest.approx(circle()[0, 1], abs=0.1)
    assert abs(residuals["r10"]) < 0.1
    assert all(abs(residuals[name]) > 1.0 for name in ("r7", "r9", "r11", "r13", "r12"))


def test_a_positive_offset_gives_a_residual_below_zero_since_it_is_estimate_less_measurement():
    samples = circle(seconds=8.0)
    samples[400:, ConditionSample._fields.index("wheel_speed_rear_left")] += 2.0
    assert last(samples)["r10"] == pytest.approx(-2.0, abs=0.1)


def test_the_printed_radicand_spoils_both_wheels_by_the_yaw_rate():
    printed = last(circle(radius=5.0, speed=3.0), residual_set(CAR, printed=True))
    right = last(circle(radius=5.0, speed=3.0))
    assert abs(right["r7"]) < 2e-3 < 0.3 < abs(printed["r7"])
    assert printed["r9"] == right["r9"]


def test_the_inverted_ratio_makes_an_angle_of_nothing():
    printed = last(circle(), residual_set(CAR, printed=True))
    assert printed["r2"] == pytest.approx(-circle()[0, 3], rel=0.01)


def test_standing_and_what_is_missing_say_that_they_are_not_there():
    standing = scan(BLOCK, circle(speed=0.0))
    assert all(standing[f"there.{each.name}"][-1] == 0.0 for each in SENSOR_RESIDUALS if each.moving)
    samples = circle()
    samples[300:, ConditionSample._fields.index("yaw_rate")] = np.nan
    result = scan(BLOCK, samples)
    for each in SENSOR_RESIDUALS:
        assert result[f"there.{each.name}"][-1] == (0.0 if "yaw_rate" in each.signals else 1.0), each.name
    assert all(np.isfinite(result[name]).all() for name in result.names if not name.startswith("held"))


@pytest.mark.parametrize("name", [each.name for each in SENSOR_RESIDUALS])
def test_a_residual_changes_with_its_signals_and_with_no_others(name):
    known = Coefficients(1.0, 1.0, 0.1, 0.5, 0.4, 0.1, 0.2, 100.0, 0.5, 10.0, 1e-3, 0.01)
    block = residual_set(CAR, known)
    random = np.random.default_rng(2)
    samples = circle(seconds=2.0) + 0.01 * random.normal(size=(200, len(ConditionSample._fields)))
    base = scan(block, samples)[f"residuals.{name}"]
    seen = set()
    for column, signal in enumerate(ConditionSample._fields):
        other = samples.copy()
        other[100:, column] += 0.2 * random.normal(size=100)
        if not np.array_equal(scan(block, other)[f"residuals.{name}"], base):
            seen.add(signal)
    assert seen == set(RESIDUALS[name].signals)


def test_one_body_is_what_two_bodies_of_the_paper_are_below_their_swing():
    """Equation (3) with the ratio put right, sampled exactly, beside the stiff rack; friction left out."""
    car, g = CAR, CAR.rack_ratio
    k, d = 1e8, 1e3
    A = np.zeros((6, 6))
    A[0, 2] = A[1, 3] = 1.0
    A[2, :4] = np.array([-(k + car.rack_stiffness), k * g, -(d + car.rack_damping), d * g]) / 3.0
    A[3, :4] = np.array([k * g, -k * g * g, d * g, -d * g * g]) / car.column_inertia
    A[2, 4], A[3, 5] = -1.0 / 3.0, 1.0 / car.column_inertia
    step = expm(0.01 * A)
    model = discretise_pair(StiffRack)
    rack = replace(car.rack, nominal_friction=0.0)
    x, y = StiffRack.State(0.0, 0.0), np.zeros(6)
    for k in range(200):
        force, torque = 100.0 * np.sin(0.05 * k), 2.0 * np.cos(0.03 * k)
        y[4:] = force, torque
        y = step @ y
        x = model.transition(x, StiffRack.Input(torque, force), model.Parameters(rack, 0.01))
        assert x.steering_wheel_angle == pytest.approx(y[1], abs=2e-3)
    slow = sorted(np.linalg.eigvals(A[:4, :4]).real)[-2:]
    assert slow == pytest.approx([-22.4, -1.45], abs=0.05)
