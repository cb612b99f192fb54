"""The rules on drives in closed form, their calibration, and its table in a vehicle file."""

import dataclasses
import math

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.monitors.condition.courses import FAULT, SUSPECT
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, OF_AUTOMATED, ConditionSample
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod.vehicles.writer import with_thresholds
from tierod_lab.papers.condition.rules.calibration import calibrate_residuals
from tierod_lab.papers.condition.rules.parameters import (
    RESIDUALS,
    Coefficients,
    ResidualCalibration,
    calibration_of,
    name_of,
    shipped_calibration,
    table_of,
)
from tierod_lab.papers.condition.rules.rule_monitor import VARIANTS, rule_monitor

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

LIMITS = dict.fromkeys(RESIDUALS, 0.2) | {"r2": 0.5, "r3": 2.0, "r4": 0.1, "r16": 1.0, "r5": 1.0, "r19": 150.0}
KNOWN = ResidualCalibration(Coefficients(), LIMITS, 0)
BEST = "rules-discriminating"


def column(samples, name):
    return samples[:, ConditionSample._fields.index(name)]


def statuses(samples, variant=BEST, known=KNOWN):
    result = scan(rule_monitor(CAR, known, variant), samples)
    return {name: result[f"statements.{name}.status"] for name in ELEMENTS}


def said(samples, variant=BEST, known=KNOWN):
    return {name for name, codes in statuses(samples, variant, known).items() if codes[-1] == FAULT}


@pytest.mark.parametrize(
    ("signal", "change"),
    [
        ("wheel_speed_rear_left", "lost"),
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
    late = column(samples, signal)[500:]
    late[:] = 0.0 if change == "lost" else late + change
    assert said(samples) == {signal}


def test_the_printed_rules_do_not_name_a_lost_wheel_and_the_corrected_do():
    samples = circle(seconds=8.0)
    assert all(said(samples, variant) == set() for variant in VARIANTS)
    column(samples, "wheel_speed_rear_left")[500:] = 0.0
    assert "wheel_speed_rear_left" not in said(samples, "rules-printed")
    assert said(samples, "rules") == {"wheel_speed_rear_left"}


def test_a_residual_without_a_threshold_is_neither_normal_nor_abnormal():
    samples = circle(radius=12.0, seconds=8.0)
    column(samples, "tie_rod_force")[500:] += 250.0
    unknown = dataclasses.replace(KNOWN, thresholds=LIMITS | {"r17": math.inf})
    assert said(samples, "rules", unknown) == set(), "its rule wants r17 normal"
    assert said(samples, "rules") == {"tie_rod_force"}


def test_a_reading_near_zero_that_is_expected_is_not_testable():
    result = scan(rule_monitor(CAR, KNOWN), circle(radius=1e6, speed=6.0))
    seen = {name for name in OF_AUTOMATED if result[f"testable.{name}"][-1]}
    assert seen == {"wheel_speed_rear_left", "wheel_speed_rear_right"}


@pytest.mark.parametrize("missing", ["wheel_speed_rear_left", "steering_wheel_angle", "gaps"])
def test_what_is_missing_declares_no_fault(missing):
    samples = circle(seconds=8.0)
    column(samples, "target_steering_wheel_angle")[:] = column(samples, "steering_wheel_angle")
    if missing == "gaps":
        samples[300:330] = samples[500:700, 3:6] = np.nan
    else:
        column(samples, missing)[:] = np.nan
    wrong = (FAULT,) if missing == "gaps" else (FAULT, SUSPECT)
    assert not any(np.isin(codes, wrong).any() for codes in statuses(samples).values())


@pytest.mark.parametrize("missing", [None, "tie_rod_force"])
@pytest.mark.parametrize("motors", [(1,), (1, 2)])
def test_while_a_residual_exceeds_its_limit_and_no_rule_explains_it_nothing_is_fault_free(motors, missing):
    samples = circle(radius=12.0, seconds=8.0)
    column(samples, "target_steering_wheel_angle")[:] = np.nanmean(column(samples, "steering_wheel_angle"))
    for number in motors:
        column(samples, f"steering_motor_{number}_target_torque")[500:] += 6.0
    if missing:
        column(samples, missing)[:] = np.nan
    judged = statuses(samples)
    before, after = ({judged[name][at] for name in (*OF_AUTOMATED, *ACTUATORS)} for at in (490, -1))
    assert not {SUSPECT, FAULT} & before
    assert FAULT in after or after == {SUSPECT}


def healthy(seconds, seed):
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * 100.0)) / 100.0
    speed = 7.0 + np.sin(0.2 * time)
    steer = 0.05 * np.sin(0.7 * time) + 0.03 * np.sin(1.7 * time)
    yaw = speed * np.tan(steer) / (CAR.front_distance + CAR.rear_distance)
    angle, along, half = steer / CAR.steering_ratio, np.gradient(speed, 0.01), 0.5 * CAR.track_width
    torque = 1.4 * angle + 0.8 * np.gradient(angle, 0.01)
    force, drive = 0.2 * CAR.mass * speed * yaw + 5.0 * torque, 10.0 + 40.0 * along
    readings = (speed - half * yaw, speed + half * yaw, yaw, angle, torque, force, along, speed * yaw)
    columns = (*readings, 0.5 * torque, 0.5 * torque, drive, drive, angle, speed)
    noisy = [each + 0.003 * random.normal(size=len(time)) for each in columns]
    names = ConditionSample._fields[: len(columns)]
    return Recording(
        {name: Channel(name, time, each, SIGNALS[name].unit) for name, each in zip(names, noisy, strict=True)}
    )


def test_calibration_finds_the_coefficients_and_thresholds_above_all_that_is_healthy():
    first, second = healthy(60.0, 1), healthy(60.0, 2)
    found = calibrate_residuals(CAR, [first], [first, second])
    known = found.coefficients
    assert (known.angle, known.rate, known.per_torque) == pytest.approx((1.4, 0.8, 5.0), rel=0.05)
    assert known.per_mass == pytest.approx(0.2, rel=0.02)
    assert all(0.0 < each < math.inf for each in found.thresholds.values())
    samples = np.full((6000, len(ConditionSample._fields)), np.nan)
    samples[:, : len(second.channels)] = np.stack([each.values for each in second.channels.values()], axis=1)
    assert not any((codes == FAULT)[200:].any() for codes in statuses(samples, "rules", found).values())


def test_too_little_driving_is_refused():
    with pytest.raises(InputError, match="too few"):
        calibrate_residuals(CAR, [healthy(5.0, 1)], [healthy(5.0, 2)])
    empty = Recording({"vehicle_speed": Channel("vehicle_speed", np.arange(3.0), np.arange(3.0), "m/s")})
    with pytest.raises(InputError, match="none of the signals"):
        calibrate_residuals(CAR, [empty], [empty])


@pytest.fixture
def vehicle(tmp_path):
    def made(table, printed=False):
        path = tmp_path / "car.toml"
        text = (SHIPPED / "smartload.toml").read_text(encoding="utf-8")
        path.write_text(with_thresholds(text, name_of(printed), table), encoding="utf-8")
        return load(path)

    return made


@pytest.mark.parametrize("printed", [False, True])
def test_a_calibration_comes_back_from_a_vehicle_file_as_it_was(vehicle, printed):
    shipped = shipped_calibration(printed)
    before = dataclasses.replace(shipped, thresholds=dict(shipped.thresholds) | {"r2": math.inf})
    after = calibration_of(vehicle(table_of(before, "an hour"), printed), printed)
    assert (after.printed, after.samples) == (printed, before.samples)
    assert dataclasses.asdict(after.coefficients) == pytest.approx(dataclasses.asdict(before.coefficients), rel=1e-5)
    assert after.thresholds == pytest.approx(before.thresholds, rel=1e-5)
    assert calibration_of(load("smartload"), printed) == shipped


@pytest.mark.parametrize(("part", "name"), [("base", "r77"), ("coefficients", "angel")])
def test_a_calibration_that_does_not_fit_is_refused_by_name(vehicle, part, name):
    table = table_of(shipped_calibration(), "an hour")
    table[part] = {**table[part], name: 1.0}
    with pytest.raises(ParameterError, match=rf"does not fit at '{name}'.*tierod identify thresholds"):
        calibration_of(vehicle(table))
