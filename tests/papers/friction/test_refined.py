from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from models.friction_paper import CAR
from papers.friction.drives import driven, enabled_seconds
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.friction.signals import FrictionGate, SteeringSample
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction.joint_model import FrictionEstimation
from tierod_lab.papers.friction.presets import (
    consistent,
    equal_low_pass,
    joint_filter,
    printed,
    printed_open,
    unscented,
)
from tierod_lab.papers.friction.refined import FrictionSample, RefinedFrictionMonitor, Sticking

PRESETS = {"printed": printed, "printed_open": printed_open, "consistent": consistent, "unscented": unscented}


def settled(monitor, drive, after: float = 50.0) -> np.ndarray:
    run = scan(monitor, drive)
    return run["friction_torque"][enabled_seconds(run["enabled"]) > after]


@pytest.mark.parametrize("friction", [4.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (8.0, 12.5))])
@pytest.mark.parametrize("preset", ["printed_open", "consistent", "unscented"])
def test_coulomb_friction_is_found_without_bias(preset, friction):
    values = settled(PRESETS[preset](CAR), driven(friction, dahl_degrees=0.01, minutes=20.0), after=200.0)
    assert len(values) > 20_000
    assert np.mean(values) == pytest.approx(friction, abs=0.15)


def test_the_literal_process_noise_reads_high_on_coulomb_friction():
    values = settled(printed(CAR), driven(4.0, dahl_degrees=0.01, minutes=20.0), after=100.0)
    assert 4.3 < np.mean(values) < 5.0


@pytest.mark.parametrize(
    ("preset", "seeds"),
    [("consistent", (1,)), *(pytest.param(each, (1, 2, 3), marks=pytest.mark.slow) for each in PRESETS)],
)
def test_dahl_friction_of_one_degree_is_found_within_known_bounds(preset, seeds):
    monitor = PRESETS[preset](CAR)
    healthy = np.concatenate([settled(monitor, driven(4.0, seed)) for seed in seeds])
    faulty = np.concatenate([settled(monitor, driven(12.5, seed)) for seed in seeds])
    assert 3.2 < np.mean(healthy) < 4.6
    assert 10.0 < np.mean(faulty) < 13.0
    assert max(np.std(healthy), np.std(faulty)) <= 1.0
    assert np.max(healthy) < 7.5 < np.min(faulty)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["printed", "consistent"])
def test_with_scatter_of_the_car_the_spread_stays_below_two(preset):
    monitor = PRESETS[preset](CAR)
    for friction in (4.0, 12.5):
        drives = [settled(monitor, driven(friction, seed, scatter=True)) for seed in (1, 2, 3)]
        assert np.std(np.concatenate(drives)) <= 2.0


@pytest.mark.parametrize("operating_point", ["measurement", "estimate"])
def test_both_operating_points_of_appendix_b_give_comparable_results(operating_point):
    values = settled(printed_open(CAR, operating_point=operating_point), driven(8.0, minutes=13.0))
    other = settled(printed_open(CAR), driven(8.0, minutes=13.0))
    assert np.mean(values) == pytest.approx(np.mean(other), abs=0.2)


def test_virtual_noise_per_sample_tracks_the_aligning_torque():
    from tierod.physics.steering import front_force_from_motion

    drive = driven(4.0)
    yaw_rate, acceleration = (drive.values[:, drive.names.index(n)] for n in ("yaw_rate", "lateral_acceleration"))
    yaw_acceleration = np.gradient(np.convolve(yaw_rate, np.ones(25) / 25.0, "same"), 0.01)
    expected = CAR.trail * front_force_from_motion(
        acceleration,
        yaw_acceleration,
        mass=CAR.mass,
        yaw_inertia=CAR.yaw_inertia,
        front_distance=CAR.front_distance,
        rear_distance=CAR.rear_distance,
    )
    errors = [
        np.sqrt(np.mean((scan(monitor, drive)["self_aligning_torque"] - expected)[1000:] ** 2))
        for monitor in (printed(CAR), printed(CAR, virtual_noise="per sample"))
    ]
    assert errors[1] < 0.6 * errors[0]


def test_a_low_pass_on_all_signals_heals_a_noisy_rate():
    noisy = driven(12.5, rate_noise=0.05)
    raw = consistent(CAR)
    smooth = replace(raw, low_pass=equal_low_pass(5.0))
    clean = np.mean(settled(raw, driven(12.5)))
    lost = clean - np.mean(settled(raw, noisy))
    assert lost > 0.8
    assert abs(clean - np.mean(settled(smooth, noisy))) < lost / 3.0


def test_consistent_covariance_sees_a_step_sooner():
    course = FrictionCourse.step(4.0, 12.5, 300.0)
    crossing = {}
    for name, monitor in (("printed", printed(CAR)), ("consistent", consistent(CAR))):
        run = scan(monitor, driven(course))
        after = run["friction_torque"][30_000:] > 7.5
        crossing[name] = enabled_seconds(run["enabled"][30_000:])[np.argmax(after)]
    assert crossing["consistent"] < crossing["printed"] < 60.0
    assert crossing["consistent"] < 40.0


def test_innovations_are_consistent_with_their_variance_where_noise_is_right():
    run = scan(printed_open(CAR), driven(4.0, dahl_degrees=0.01, minutes=20.0))
    assert 1.0 < np.mean(run["nis"][5000:]) < 6.0
    assert np.all(run["present"] == 3.0)


@pytest.mark.parametrize("column", range(6))
@pytest.mark.parametrize("preset", PRESETS)
def test_a_missing_signal_closes_the_gate_and_harms_nothing(preset, column):
    monitor = PRESETS[preset](CAR)
    samples = driven(4.0).values[6000:9000, :6].copy()
    samples[1000:1300, column] = np.nan
    run = scan(monitor, samples)
    assert np.all(run["enabled"][1000:1300] == 0.0)
    assert np.all(np.isfinite(run["friction_torque"]))
    assert np.all(run["friction_torque"][1000:1300] == run["friction_torque"][999])
    assert np.all(np.isfinite(run.state.values))
    whole = scan(monitor, driven(4.0).values[6000:9000, :6])
    assert run["friction_torque"][-1] == pytest.approx(whole["friction_torque"][-1], abs=0.3)


@pytest.mark.parametrize("low_pass", [None, equal_low_pass(5.0)])
def test_nothing_but_missing_samples_leaves_the_start(low_pass):
    monitor = replace(consistent(CAR), low_pass=low_pass)
    run = scan(monitor, np.full((500, 6), np.nan))
    assert np.all(run["friction_torque"] == 3.0)
    assert np.all(run["present"] == 0.0)
    assert np.all(np.isfinite(run["self_aligning_torque"]))


@pytest.mark.parametrize("seconds", [10, 300])
@pytest.mark.parametrize("columns", [slice(None), [0, 1, 4]])
@pytest.mark.parametrize("preset", PRESETS)
def test_a_long_gap_costs_nothing(preset, columns, seconds):
    samples = driven(8.0, minutes=13.0).values[:, :6].copy()
    gap = slice(21_500, 21_500 + 100 * seconds)
    hole = samples[gap]
    hole[:, columns] = np.nan
    samples[gap] = hole
    kept = scan(PRESETS[preset](CAR), samples)["friction_torque"]
    assert np.max(np.abs(kept[gap.stop : gap.stop + 1000] - kept[gap.start])) < 0.5


def test_without_a_new_start_a_long_gap_spoils_the_estimate():
    changes = []
    for start in range(15_000, 48_000, 3_000):
        samples = driven(8.0, minutes=13.0).values[:, :6].copy()
        samples[start : start + 30_000, [0, 1, 4]] = np.nan
        kept = scan(replace(consistent(CAR), longest_gap=math.inf), samples)["friction_torque"]
        changes.append(np.max(np.abs(kept[start + 30_000 : start + 33_000] - kept[start])))
    assert max(changes) > 2.0


def test_sticking_takes_friction_out_of_the_balance():
    torque = np.zeros((400, 6))
    torque[:, 2] = 3.0
    without, with_it = (
        scan(replace(consistent(CAR), sticking=sticking), torque)["self_aligning_torque"]
        for sticking in (None, Sticking(torque_deviation=40.0))
    )
    assert abs(with_it[-1]) < 0.5 * abs(without[-1])


def test_the_gate_with_a_speed_asks_for_the_speed():
    slow = replace(consistent(CAR), gate=FrictionGate(minimum_speed=3.0))
    assert consistent(CAR).Sample is FrictionSample
    assert slow.Sample is SteeringSample
    drive = driven(4.0)
    run, always = scan(slow, drive), scan(consistent(CAR), drive)
    speed = drive.values[:, drive.names.index("vehicle_speed")]
    np.testing.assert_array_equal(run["enabled"], always["enabled"] * (speed > 3.0))


def test_wrong_choices_are_refused_with_the_right_ones():
    good = consistent(CAR)
    with pytest.raises(ParameterError, match="maskable"):
        RefinedFrictionMonitor(replace(good.filter, maskable=()))
    with pytest.raises(ParameterError, match="'measurement' or 'estimate'"):
        replace(good, operating_point="latest")
    with pytest.raises(ParameterError, match="signals=SteeringSample"):
        replace(good, gate=FrictionGate(minimum_speed=3.0), low_pass=equal_low_pass(5.0))
    with pytest.raises(ParameterError, match="as printed"):
        joint_filter(
            CAR,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1.0, 0.001),
            virtual_noise="sqrt",
            covariance_update="printed",
            initial_friction_variance=1.0,
        )


def test_the_filter_starts_at_the_printed_state():
    belief = printed(CAR).init().belief
    assert belief.mean == FrictionEstimation.State(0.0, 0.0, 0.0, 0.0, 3.0)
    assert math.isclose(belief.covariance[-1], 1.0)
