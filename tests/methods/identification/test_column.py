"""column"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from methods.identification.bench import FREE, LOCKED, RAMPS, SINES, TRUTH, changed, recordings, row
from tierod.core.errors import InputError, ParameterError
from tierod.methods.identification.column import identify_column, known_free
from tierod.methods.identification.column_fit import ColumnFit, WheelMotion, wheel_side
from tierod.methods.identification.experiment import (
    Estimate,
    Free,
    blind_directions,
    normalised_error,
    refusal,
    whiteness,
)
from tierod.methods.identification.regression import instrumental

ROUGH = replace(TRUTH, motor_damping=1.3 * TRUTH.motor_damping, motor_friction=0.07, motor_friction_stiffness=1.4)


@pytest.fixture(scope="module")
def result():
    return identify_column(
        ROUGH, {name: recordings()[name] for name in (FREE, LOCKED)}, deviations={"motor_damping": 1.0}
    )


def test_it_finds_damping_and_friction(result):
    found = {each.name: each for each in result.found}
    assert list(found) == ["steering_wheel_damping", "motor_damping", "motor_friction", "motor_friction_stiffness"]
    for name, limit in zip(found, (0.005, 0.02, 0.02, 0.05), strict=True):
        right = getattr(TRUTH, name)
        assert found[name].value == pytest.approx(right, rel=limit)
        assert found[name].value == pytest.approx(right, abs=5.0 * found[name].deviation)
        assert found[name].low < found[name].value < found[name].high
    assert found["motor_damping"].before_deviation == 1.0
    assert found["motor_damping"].change == pytest.approx(1.0 / 1.3 - 1.0, abs=0.01)
    assert [each.method for each in result.found] == ["instruments", *["likelihood"] * 3]


def test_what_the_bench_adds_is_nil(result):
    assert result.estimate["motor_torque_gain"] == pytest.approx(1.0, abs=0.002)
    assert result.estimate.input_deviation[0] < 1e-3
    assert result.remarks == ()
    assert result.explained


def test_what_is_in_doubt_is_said_with_its_own_reason(result):
    assert result.doubt == ""
    stopped = replace(result, estimate=replace(result.estimate, converged=False))
    assert stopped.doubt == "the search did not converge"
    assert replace(stopped, explained=False).doubt == "the model does not explain these recordings"


def test_every_experiment_is_left_out_once(result):
    assert [each.name for each in result.left_out] == [FREE, LOCKED]
    without_free, without_locked = result.left_out
    assert "steering_wheel_damping" not in without_free.values
    assert without_locked.values["motor_friction"] == pytest.approx(0.1, rel=0.02)
    assert without_locked.errors["driver_torque"] < 0.05
    assert "steering_wheel_angle" not in without_locked.errors


def test_simulated_and_measured_agree_and_residuals_are_white(result):
    assert all(each.errors["driver_torque"] < 0.05 for each in result.shown)
    assert all(abs(each.largest) < 0.1 for each in result.whiteness.values())
    assert np.max(np.abs(result.shown[0].friction)) == pytest.approx(0.1, rel=0.02)


def test_slow_ramps_alone_do_not_identify_the_damping():
    with pytest.raises(InputError, match=r"do not excite motor_damping.*sweep or steps with the wheel free"):
        identify_column(replace(ROUGH, motor_damping=1e-5), {RAMPS: recordings()[RAMPS]}, ("motor_damping",))


def test_friction_that_is_held_and_wrong_is_named():
    wrong = replace(TRUTH, motor_friction=0.25, motor_friction_stiffness=5.0)
    with pytest.raises(InputError, match=r"motor_friction, held at 0\.25 .* near 0\.(09|1)[0-9]* .*--free"):
        identify_column(wrong, {SINES: recordings()[SINES]}, ("motor_damping", "gear_stiffness"))


def test_a_locked_wheel_shows_nothing_of_the_wheel():
    with pytest.raises(
        InputError, match="steering_wheel_damping is not identifiable; record a sweep with the wheel free"
    ):
        identify_column(ROUGH, {LOCKED: recordings()[LOCKED]}, ("steering_wheel_damping",))


@pytest.mark.parametrize(("name", "words"), [("motor_ratio", "counted"), ("motor_dampin", "motor_damping")])
def test_parameters_that_cannot_be_looked_for(name, words):
    with pytest.raises(ParameterError, match=words):
        identify_column(ROUGH, {SINES: recordings()[SINES]}, (name,))


def test_inertia_and_stiffness_can_be_looked_for():
    assert {"motor_inertia", "gear_inertia", "gear_stiffness", "torsion_bar_stiffness"} < set(known_free())


def estimate(information):
    count = len(information)
    free = tuple(Free(name) for name in ("motor_friction", "motor_damping")[:count])
    return Estimate(free, (1.0,) * count, (1.0,) * count, np.eye(count), information, 0.0, ())


def test_a_direction_of_little_information_is_named():
    along = np.array([1.0, 1.0]) / np.sqrt(2.0)
    across = np.array([1.0, -1.0]) / np.sqrt(2.0)
    found = blind_directions(
        estimate(1e6 * np.outer(along, along) + np.outer(across, across)), ["motor_friction", "motor_damping"]
    )
    assert len(found) == 1
    assert found[0].deviation == pytest.approx(1.0)
    assert set(found[0].names) == {"motor_friction", "motor_damping"}
    words = refusal(found, ["drive.mf4"], {"motor_friction": "ramps"})
    assert "this recording does not excite" in words
    assert "record ramps instead" in words


def test_what_is_unknown_besides_counts():
    information = np.array([[100.0, 99.9], [99.9, 100.0]])
    assert blind_directions(estimate(np.array([[100.0]])), ["motor_friction"]) == []
    found = blind_directions(estimate(information), ["motor_friction"])
    assert found[0].deviation == pytest.approx(1.0 / np.sqrt(100.0 - 99.9**2 / 100.0))


def test_normalised_error_and_whiteness():
    random = np.random.default_rng(1)
    white = random.standard_normal(20_000)
    assert normalised_error(white + 0.1, white) == pytest.approx(0.1, rel=0.02)
    assert whiteness([white]).outside < 0.25
    assert whiteness([np.zeros(100)]) == (0.0, 0.0)
    coloured = np.convolve(white, [1.0, 0.8], "valid")
    assert whiteness([coloured]).largest == pytest.approx(0.8 / 1.64, abs=0.03)


def test_a_gap_does_not_pass_for_motion_of_the_wheel():
    gap = changed(recordings()[FREE], driver_torque=lambda t, v: (t, np.where((t > 1.3) & (t < 1.8), np.nan, v)))
    fit = ColumnFit(TRUTH, ("steering_wheel_inertia", "steering_wheel_damping"))
    values, _ = fit._wheel([row(FREE, gap)])
    for name, (value, deviation) in values.items():
        assert value == pytest.approx(getattr(TRUTH, name), abs=4.0 * deviation, rel=0.01)


INERTIA, DAMPING = 0.04, 0.3


def motion(noise=0.0, seed=1, count=8000):
    """A wheel that swings by a few sines of known derivatives; the torque follows from them."""
    random, time = np.random.default_rng(seed), np.arange(count) * 1e-3
    frequencies, phases = np.array([0.4, 1.1, 2.3, 4.1]) * 2.0 * np.pi, np.array([0.0, 1.0, 2.0, 3.0])
    waves = 0.5 / frequencies * np.sin(np.outer(time, frequencies) + phases)
    angle = waves.sum(axis=1)
    rate = (0.5 * np.cos(np.outer(time, frequencies) + phases)).sum(axis=1)
    torque = -INERTIA * -(waves * frequencies**2).sum(axis=1) - DAMPING * rate + 0.1
    noisy = [values + noise * random.standard_normal(count) for values in (angle, angle, torque)]
    return WheelMotion(*noisy, 1e-3)


def test_without_noise_it_is_exact():
    found = wheel_side([motion()])
    assert found.inertia == pytest.approx(INERTIA, rel=1e-6)
    assert found.damping == pytest.approx(DAMPING, rel=1e-6)
    assert wheel_side([motion()], INERTIA).damping == pytest.approx(DAMPING, rel=1e-6)


def test_with_noise_the_deviations_say_how_exact_it_is():
    found = [wheel_side([motion(2e-3, seed)]) for seed in range(30)]
    inertia, damping = np.array([each.inertia for each in found]), np.array([each.damping for each in found])
    assert np.mean(inertia) == pytest.approx(INERTIA, abs=3.0 * np.std(inertia) / np.sqrt(30.0))
    assert np.mean([each.inertia_deviation for each in found]) == pytest.approx(np.std(inertia), rel=0.4)
    assert np.mean([each.damping_deviation for each in found]) == pytest.approx(np.std(damping), rel=0.4)


def test_instruments_take_away_the_bias_of_noisy_regressors():
    random = np.random.default_rng(3)
    true = random.standard_normal(20_000)
    noisy, other = (true + 0.7 * random.standard_normal(20_000) for _ in range(2))
    target = 2.0 * true + 0.1 * random.standard_normal(20_000)
    plain = instrumental([target], [noisy[:, None]], [noisy[:, None]])
    found = instrumental([target], [noisy[:, None]], [other[:, None]])
    assert plain.values[0] == pytest.approx(2.0 / 1.49, rel=0.03)
    assert found.values[0] == pytest.approx(2.0, abs=4.0 * np.sqrt(found.covariance[0, 0]))


def test_a_wheel_at_rest_is_refused():
    still = WheelMotion(np.zeros(4000), np.zeros(4000), np.zeros(4000), 1e-3)
    with pytest.raises(InputError, match="more motion"):
        wheel_side([still])
