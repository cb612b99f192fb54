import dataclasses

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.monitors.condition.courses import FAULT, SUSPECT
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, OF_AUTOMATED, ConditionSample
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration, calibrate_residuals
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.readings import Excitation, ResidualThreshold
from tierod_lab.papers.condition.rules.rule_monitor import rule_monitor
from tierod_lab.papers.condition.rules.symptoms import FILES, rules

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

LIMITS = dict.fromkeys(RESIDUALS, 0.2) | {"r2": 0.5, "r3": 2.0, "r4": 0.1, "r16": 1.0, "r5": 1.0, "r19": 150.0}
KNOWN = ResidualCalibration(Coefficients(), {k: ResidualThreshold(v) for k, v in LIMITS.items()}, {}, 0)


def index(name):
    return ConditionSample._fields.index(name)


def said(samples, variant="rules-discriminating"):
    result = scan(rule_monitor(CAR, KNOWN, variant), samples)
    return {name for name in OF_AUTOMATED if result[f"statements.{name}.status"][-1] == FAULT}


@pytest.mark.parametrize(
    ("signal", "change"),
    [
        ("wheel_speed_rear_left", "lost"),
        ("wheel_speed_rear_right", "lost"),
        ("wheel_speed_rear_left", 2.0),
        ("wheel_speed_rear_right", -2.0),
        ("yaw_rate", 0.4),
        ("yaw_rate", "lost"),
        ("steering_wheel_angle", 4.0),
        ("steering_shaft_torque", 3.0),
        ("tie_rod_force", 250.0),
    ],
)
def test_a_sensor_that_fails_on_a_circle_is_named(signal, change):
    samples = circle(radius=12.0, seconds=8.0)
    column = samples[500:, index(signal)]
    column[:] = 0.0 if change == "lost" else column + change
    assert said(samples) == {signal}


def test_a_residual_without_a_threshold_is_neither_normal_nor_abnormal():
    samples = circle(radius=12.0, seconds=8.0)
    samples[500:, index("tie_rod_force")] += 250.0
    unknown = dataclasses.replace(KNOWN, thresholds={**KNOWN.thresholds, "r17": ResidualThreshold(np.inf)})
    result = scan(rule_monitor(CAR, unknown, "rules"), samples)
    assert not (result["statements.tie_rod_force.status"] == FAULT).any(), "its rule wants r17 normal"
    assert said(samples, "rules") == {"tie_rod_force"}


def test_a_fault_free_circle_names_nothing():
    assert all(said(circle(), variant) == set() for variant in FILES)


def test_the_printed_rules_do_not_name_a_lost_wheel_and_the_corrected_do():
    samples = circle(seconds=8.0)
    samples[500:, index("wheel_speed_rear_left")] = 0.0
    assert "wheel_speed_rear_left" not in said(samples, "rules-printed")
    assert said(samples, "rules") == {"wheel_speed_rear_left"}


def test_a_reading_near_zero_that_is_expected_is_not_testable():
    straight = circle(radius=1e6, speed=6.0)
    result = scan(rule_monitor(CAR, KNOWN), straight)
    flags = {name: 1.0 - result[f"testable.{name}"][-1] for name in OF_AUTOMATED}
    assert flags == dict.fromkeys(OF_AUTOMATED, 1.0) | {"wheel_speed_rear_left": 0.0, "wheel_speed_rear_right": 0.0}


@pytest.mark.parametrize("missing", OF_AUTOMATED)
def test_a_signal_that_the_car_does_not_have_declares_no_fault(missing):
    samples = followed(circle(seconds=4.0))
    samples[:, index(missing)] = np.nan
    result = scan(rule_monitor(CAR, KNOWN, "rules-discriminating"), samples)
    for name in ELEMENTS:
        assert not np.isin(result[f"statements.{name}.status"], (FAULT, SUSPECT)).any()
    assert result[f"testable.{missing}"][-1] == 0.0


def test_gaps_and_a_start_in_mid_drive_declare_no_fault():
    samples = circle(seconds=8.0)
    samples[300:330] = np.nan
    samples[500:700, 3:6] = np.nan
    result = scan(rule_monitor(CAR, KNOWN, "rules-discriminating"), samples)
    assert not any((result[f"statements.{name}.status"] == FAULT).any() for name in OF_AUTOMATED)


@pytest.mark.parametrize("variant", FILES)
def test_every_sensor_and_actuator_has_a_rule(variant):
    assert set(rules(variant).faults) == {*OF_AUTOMATED, *ACTUATORS}


def test_steering_motors_coincide_in_the_tables_of_the_paper():
    assert rules("rules").not_isolable() == (("steering_motor_1", "steering_motor_2"),)
    assert rules("rules-discriminating").not_isolable() == ()


def test_a_rule_file_of_ones_own_may_speak_of_a_few_sensors(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        'name = "own"\ndescription = "d"\nsource = "s"\n[[rule]]\nfault = "yaw_rate"\nabnormal = ["r4"]\n',
        encoding="utf-8",
    )
    samples = circle(radius=12.0, seconds=8.0)
    samples[500:, index("yaw_rate")] += 0.5
    assert said(samples, str(path)) == {"yaw_rate"}
    with pytest.raises(ParameterError, match="cannot be read"):
        rules(str(tmp_path / "none.toml"))


def test_a_threshold_widens_with_excitation_whatever_its_sign():
    threshold = ResidualThreshold(0.1, per_lateral_acceleration=0.05, centre=0.02)
    assert threshold.adapts
    assert not ResidualThreshold(0.1).adapts
    for lateral in (2.0, -2.0):
        assert threshold.ratio(0.42, Excitation(8.0, 0.0, lateral, 0.0)) == pytest.approx(2.0)


def healthy(seconds, seed):
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * 100.0)) / 100.0
    speed = 7.0 + np.sin(0.2 * time)
    steer = 0.05 * np.sin(0.7 * time) + 0.03 * np.sin(1.7 * time)
    yaw = speed * np.tan(steer) / CAR.wheelbase
    angle = steer / CAR.steering_ratio
    torque = 1.4 * angle + 0.8 * np.gradient(angle, 0.01)
    half = 0.5 * CAR.track_width
    values = dict.fromkeys(ConditionSample._fields, 0.0 * time) | {
        "wheel_speed_rear_left": speed - half * yaw,
        "wheel_speed_rear_right": speed + half * yaw,
        "yaw_rate": yaw,
        "steering_wheel_angle": angle,
        "steering_shaft_torque": torque,
        "tie_rod_force": 0.2 * CAR.mass * speed * yaw + 5.0 * torque,
        "longitudinal_acceleration": np.gradient(speed, 0.01),
        "lateral_acceleration": speed * yaw,
        "target_vehicle_speed": speed,
        "target_steering_wheel_angle": angle,
        "steering_motor_1_target_torque": 0.5 * torque,
        "steering_motor_2_target_torque": 0.5 * torque,
        "target_drive_torque_left": 10.0 + 40.0 * np.gradient(speed, 0.01),
        "target_drive_torque_right": 10.0 + 40.0 * np.gradient(speed, 0.01),
    }
    noisy = {name: column + 0.003 * random.normal(size=len(time)) for name, column in values.items()}
    return Recording({name: Channel(name, time, column, SIGNALS[name].unit) for name, column in noisy.items()})


def test_calibration_finds_the_coefficients_and_thresholds_above_all_that_is_healthy():
    first, second = healthy(60.0, 1), healthy(60.0, 2)
    found = calibrate_residuals(CAR, [first], [first, second])
    assert found.coefficients.angle == pytest.approx(1.4, rel=0.05)
    assert found.coefficients.rate == pytest.approx(0.8, rel=0.05)
    assert found.coefficients.per_mass == pytest.approx(0.2, rel=0.02)
    assert found.coefficients.per_torque == pytest.approx(5.0, rel=0.05)
    assert all(0.0 < each.base < np.inf and not each.adapts for each in found.thresholds.values())
    adaptive = calibrate_residuals(CAR, [first], [first, second], adaptive=True)
    assert any(each.adapts for each in adaptive.thresholds.values())
    monitor = rule_monitor(CAR, found)
    columns = np.stack([second[name].values for name in ConditionSample._fields], axis=1)
    result = scan(monitor, columns)
    assert not any((result[f"statements.{name}.status"] == FAULT)[200:].any() for name in OF_AUTOMATED)


def test_too_little_driving_is_refused():
    with pytest.raises(InputError, match="too few"):
        calibrate_residuals(CAR, [healthy(5.0, 1)], [healthy(5.0, 2)])
    empty = Recording({"vehicle_speed": Channel("vehicle_speed", np.arange(3.0), np.arange(3.0), "m/s")})
    with pytest.raises(InputError, match="none of the signals"):
        calibrate_residuals(CAR, [empty], [empty])


@pytest.mark.parametrize("missing", [None, "tie_rod_force", "yaw_rate"])
@pytest.mark.parametrize("motors", [(1,), (1, 2)])
def test_while_a_residual_exceeds_its_limit_and_no_rule_explains_it_nothing_is_fault_free(motors, missing):
    samples = followed(circle(radius=12.0, seconds=8.0))
    for number in motors:
        samples[500:, index(f"steering_motor_{number}_target_torque")] += 6.0
    if missing:
        samples[:, index(missing)] = np.nan
    result = scan(rule_monitor(CAR, KNOWN, "rules-discriminating"), samples)
    before, states = (
        {name: result[f"statements.{name}.status"][at] for name in (*OF_AUTOMATED, *ACTUATORS)} for at in (490, -1)
    )
    assert not {SUSPECT, FAULT} & set(before.values())
    assert SUSPECT in states.values() or FAULT in states.values()
    if FAULT not in states.values():
        assert set(states.values()) == {SUSPECT}


def followed(samples):
    samples[:, index("target_steering_wheel_angle")] = np.nanmean(samples[:, index("steering_wheel_angle")])
    return samples
