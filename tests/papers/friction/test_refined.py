"""The paper's joint filter and its readings; the printed form against an oracle is in tests/agreement."""

import math
from dataclasses import replace

import numpy as np
import pytest

from models.friction_paper import CAR
from papers.friction.drives import driven, enabled_seconds
from tierod.core.graph import jacobian, scan
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction.joint_model import FrictionEstimation
from tierod_lab.papers.friction.presets import consistent, linearised, printed, printed_open, unscented
from tierod_lab.papers.friction.refined import LinearisedFrictionEstimation as Model
from tierod_lab.papers.friction.refined import Sticking, VariableRatioParameters, smooth_sign_slope

PRESETS = {"printed": printed, "printed_open": printed_open, "consistent": consistent, "unscented": unscented}


def settled(monitor, drive, after=50.0):
    run = scan(monitor, drive)
    return run["friction_torque"][enabled_seconds(run["enabled"]) > after]


@pytest.mark.parametrize("preset", ["printed_open", "consistent", "unscented"])
def test_coulomb_friction_is_found_without_bias(preset):
    values = settled(PRESETS[preset](CAR), driven(4.0, dahl_degrees=0.01, minutes=20.0), after=200.0)
    assert np.mean(values) == pytest.approx(4.0, abs=0.15)


def test_dahl_friction_of_one_degree_reads_low_within_known_bounds():
    healthy, faulty = (settled(consistent(CAR), driven(level, 1)) for level in (4.0, 12.5))
    assert 3.2 < np.mean(healthy) < 4.6
    assert 10.0 < np.mean(faulty) < 13.0
    assert np.max(healthy) < 7.5 < np.min(faulty)
    assert np.mean(settled(unscented(CAR), driven(12.5, 1))) == pytest.approx(np.mean(faulty), abs=0.3)


def test_consistent_covariance_sees_a_step_sooner():
    crossing = {}
    for name in ("printed", "consistent"):
        run = scan(PRESETS[name](CAR), driven(FrictionCourse.step(4.0, 12.5, 300.0)))
        after = run["friction_torque"][30_000:] > 7.5
        crossing[name] = enabled_seconds(run["enabled"][30_000:])[np.argmax(after)]
    assert crossing["consistent"] < crossing["printed"] < 60.0
    assert crossing["consistent"] < 40.0


def test_innovations_are_consistent_with_their_variance_where_noise_is_right():
    run = scan(printed_open(CAR), driven(4.0, dahl_degrees=0.01, minutes=20.0))
    assert 1.0 < np.mean(run["nis"][5000:]) < 6.0


@pytest.mark.parametrize("column", [0, 2, 5])
def test_a_missing_signal_closes_the_gate_and_harms_nothing(column):
    samples = driven(4.0).values[6000:9000, :6].copy()
    whole = scan(consistent(CAR), samples)
    samples[1000:1300, column] = np.nan
    run = scan(consistent(CAR), samples)
    assert np.all(run["enabled"][1000:1300] == 0.0)
    assert np.all(run["friction_torque"][1000:1300] == run["friction_torque"][999])
    assert np.all(np.isfinite(run.state.values))
    assert run["friction_torque"][-1] == pytest.approx(whole["friction_torque"][-1], abs=0.3)


@pytest.mark.parametrize("columns", [slice(None), [0, 1, 4]])
def test_a_gap_of_minutes_costs_nothing(columns):
    samples = driven(8.0, minutes=13.0).values[:, :6].copy()
    hole = samples[21_500:51_500]
    hole[:, columns] = np.nan
    kept = scan(consistent(CAR), samples)["friction_torque"]
    assert np.max(np.abs(kept[51_500:52_500] - kept[21_500])) < 0.5


def test_sticking_takes_friction_out_of_the_balance():
    torque = np.zeros((400, 6))
    torque[:, 2] = 3.0
    without, with_it = (
        scan(replace(consistent(CAR), sticking=sticking), torque)["self_aligning_torque"]
        for sticking in (None, Sticking(torque_deviation=40.0))
    )
    assert abs(with_it[-1]) < 0.5 * abs(without[-1])


GROWTH, WIDTH = 0.06, 0.02
KNOWN = {name: getattr(CAR, name) for name in CAR.__dataclass_fields__}
THERE = np.array([1.1, 0.013, 0.2, 90.0, 6.0])


def rate_after(x):
    """Eq (18), its sign smoothed: exact zero-order hold, corrected as in the errata."""
    angle, rate, _, aligning, friction = x
    decay = math.exp(-0.01 * 0.8 / 0.10)
    ratio = (1.0 + GROWTH * angle * angle) / 15.5
    return decay * rate + (1.0 - decay) / 0.8 * (4.0 - ratio * aligning - friction * math.tanh(rate / WIDTH))


def test_eq_19_is_the_derivative_of_the_nonlinear_balance():
    parameters = VariableRatioParameters(**KNOWN, smoothing_rate=WIDTH, steering_ratio_growth=GROWTH)
    inputs = Model.Input(2.0, 0.1, 1.5, math.tanh(THERE[1] / WIDTH), THERE[0], THERE[1], THERE[3], THERE[4])
    found = jacobian(lambda x: Model.transition(x, inputs, parameters), Model.State(*THERE))[1]
    for place, step in enumerate((1e-6, 1e-7, 1e-6, 1e-4, 1e-5)):
        ahead, behind = (rate_after(THERE + sign * step * np.eye(5)[place]) for sign in (1.0, -1.0))
        assert found[place] == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-5, abs=1e-9), place


def test_without_growth_and_terms_it_is_the_printed_filter():
    plain = VariableRatioParameters(**KNOWN, with_sign_slope=0.0)
    x = Model.State(0.4, 0.6, 0.1, 120.0, 5.0)
    found = Model.transition(x, Model.Input(3.0, 0.2, 2.0, 1.0, 1.0, 0.3, 80.0, 4.0), plain)
    assert found == pytest.approx(FrictionEstimation.transition(x, FrictionEstimation.Input(3.0, 0.2, 2.0, 1.0), CAR))


def test_the_delta_integrates_to_two_as_the_jump_of_a_sign():
    rates = np.linspace(-1.0, 1.0, 10001)
    area = np.trapezoid([smooth_sign_slope(float(rate), WIDTH) for rate in rates], rates)
    assert area == pytest.approx(2.0, rel=1e-6)


def test_with_the_right_ratio_the_friction_is_found():
    time = 0.01 * np.arange(12_000)
    angle, rate = 1.5 * np.sin(0.5 * time), 0.75 * np.cos(0.5 * time)
    lateral = 2.0 * angle
    aligning = CAR.trail * CAR.rear_distance * CAR.mass * lateral / (CAR.front_distance + CAR.rear_distance)
    ratio = CAR.steering_ratio * (1.0 + GROWTH * angle**2)
    total = -0.25 * CAR.column_inertia * angle + CAR.column_damping * rate + 6.0 * np.sign(rate) + ratio * aligning
    motor = 0.4 * total / CAR.motor_ratio
    seen = np.column_stack([angle, rate, 0.6 * total, motor, np.zeros(len(time)), lateral])
    known, plain = (
        scan(linearised(CAR, steering_ratio_growth=growth), seen)["friction_torque"][-1] for growth in (GROWTH, 0.0)
    )
    assert known == pytest.approx(6.0, abs=0.6)
    assert abs(known - 6.0) <= abs(plain - 6.0) + 0.05
