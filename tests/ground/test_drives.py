import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.signals import SIGNALS
from tierod_lab.ground import City, DryFriction, EpsCar, FrictionCourse, Sensor, SensorSet, drive, lock_to_lock
from tierod_lab.ground.drives import CHANNELS
from tierod_lab.ground.steering.friction import Dahl


def level(course, *time):
    change = course.behaviour().change(np.array(time), None)
    assert change.gain == 0.0
    return change.offset


def test_constant_step_and_straight_rise():
    time = (0.0, 9.999, 10.0, 15.0, 20.0, 30.0)
    np.testing.assert_array_equal(level(FrictionCourse.constant(4.0), *time), 4.0)
    np.testing.assert_array_equal(level(FrictionCourse.step(4.0, 8.0, 10.0), *time), [4, 4, 8, 8, 8, 8])
    np.testing.assert_array_equal(level(FrictionCourse.step(4, 8, 10), *time), [4, 4, 8, 8, 8, 8])
    np.testing.assert_allclose(level(FrictionCourse((10.0, 20.0), (4.0, 8.0)), *time), [4, 4, 4, 6, 8, 8])


def test_several_corners():
    course = FrictionCourse((0.0, 10.0, 10.0, 20.0), (4.0, 4.0, 6.0, 8.0))
    np.testing.assert_allclose(level(course, 5.0, 10.0, 15.0, 99.0), [4, 6, 7, 8])


@pytest.mark.parametrize(
    ("times", "levels", "message"),
    [
        ((), (), "one level per time"),
        ((0.0, 1.0), (4.0,), "one level per time"),
        ((1.0, 0.0), (4.0, 5.0), "backwards"),
        ((1.0, 1.0, 1.0), (4.0, 5.0, 6.0), "three corners at one instant"),
        ((0.0,), (-1.0,), "not negative"),
        ((0.0,), (float("nan"),), "finite"),
    ],
)
def test_impossible_courses_are_refused(times, levels, message):
    with pytest.raises(ParameterError, match=message):
        FrictionCourse(times, levels)


CANONICAL = CHANNELS
IDEAL = SensorSet.ideal().only(CHANNELS)


def gate(recording):
    """The paper's enabling condition, Mohtat et al., eq (14)."""
    driver, motor = recording["driver_torque"].values, recording["motor_torque"].values
    rate = np.abs(recording["steering_wheel_rate"].values)
    return (np.abs(driver) > 0.5) & (driver * motor > 0.0) & (rate > 0.05) & (rate < 1.0)


def same(one, other, names=CANONICAL):
    return all(np.array_equal(one[name].values, other[name].values) for name in names)


@pytest.fixture(scope="module")
def healthy():
    return drive(minutes=13.0, friction=4.0, seed=1)


def test_canonical_channels_at_100_hz_in_their_units(healthy):
    for name in CANONICAL:
        channel = healthy[name]
        assert channel.unit == SIGNALS[name].unit
        assert len(channel.values) == len(channel.time) == 78_000
        np.testing.assert_allclose(np.diff(channel.time), 0.01, rtol=1e-6, equal_nan=False)
        assert np.all(np.isfinite(channel.values))
        low, high = SIGNALS[name].plausible
        assert low < channel.values.min() < channel.values.max() < high
    assert all(name in CANONICAL or name.startswith("truth_") for name in healthy.names)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("level", "dahl_angle"),
    [*(pytest.param(*each, marks=pytest.mark.slow) for each in ((4.0, 0.3), (8.0, 1.0))), (12.5, 3.0)],
)
def test_gate_of_the_paper_is_open_about_a_third_of_the_time_and_more_with_much_friction(
    healthy, seed, level, dahl_angle
):
    car = EpsCar()
    friction = DryFriction(law=Dahl(math.radians(dahl_angle)))
    car = replace(car, steering=replace(car.steering, friction=friction))
    recording = drive(car, minutes=8.0, friction=level, seed=seed)
    assert 0.28 <= np.mean(gate(healthy)) <= 0.52
    assert 0.28 <= np.mean(gate(recording)) <= 0.52
    require_on_road(recording)


def test_turning_is_balanced(healthy):
    enabled = gate(healthy)
    rate, torque = healthy["steering_wheel_rate"].values, healthy["truth_self_aligning_torque"].values
    assert 0.4 < np.mean(rate[enabled] > 0.0) < 0.6
    assert 0.35 < np.mean(torque[enabled] * rate[enabled] > 0.0) < 0.65


def test_signs_of_a_left_turn_agree(healthy):
    angle = healthy["steering_wheel_angle"].values
    left = angle > 0.3
    assert np.mean(healthy["yaw_rate"].values[left] > 0.0) > 0.97
    assert np.mean(healthy["lateral_acceleration"].values[left] > 0.0) > 0.97
    speed, yaw_rate = healthy["vehicle_speed"].values, healthy["yaw_rate"].values
    assert np.corrcoef(speed * yaw_rate, healthy["lateral_acceleration"].values)[0, 1] > 0.97


def test_city_country_and_motorway_are_driven(healthy):
    speed = healthy["vehicle_speed"].values
    end = healthy["truth_distance"].values[-1]
    kinds = {kind for place, kind in healthy.metadata["stretches"] if place < end}
    assert kinds == {"city", "country", "motorway"}
    assert np.mean(speed < 14.0) > 0.15
    assert np.mean((speed > 15.0) & (speed < 28.0)) > 0.2
    assert np.mean(speed > 27.0) > 0.1


def test_car_stays_near_the_road_and_below_the_limit_of_adhesion(healthy):
    require_on_road(healthy)


def require_on_road(recording):
    assert np.max(np.abs(recording["truth_lateral_offset"].values)) < 3.0
    assert np.max(np.abs(recording["lateral_acceleration"].values)) < 6.0


def test_same_seed_same_bits_and_another_seed_another_drive():
    one, again, other = (drive(minutes=1.0, seed=seed, scatter=True) for seed in (5, 5, 6))
    assert same(one, again, one.names)
    assert not any(np.array_equal(one[name].values, other[name].values) for name in CANONICAL)


def test_seed_keeps_the_route_whatever_else_changes():
    one = drive(minutes=1.2, friction=4.0, seed=5)
    other = drive(minutes=1.2, friction=12.5, seed=5, scatter=True, sensors=IDEAL)
    truth = drive(minutes=1.2, friction=4.0, seed=5, sensors=IDEAL)
    assert one.metadata["stretches"] == other.metadata["stretches"]
    assert np.max(np.abs(truth["truth_distance"].values - other["truth_distance"].values)) < 5.0
    assert not same(truth, other, ["driver_torque"])


def test_a_drive_in_pieces_is_one_drive():
    recording = drive(minutes=1.2, seed=3, sensors=IDEAL)
    angle = recording["steering_wheel_angle"].values
    rate = recording["steering_wheel_rate"].values
    np.testing.assert_allclose(np.diff(angle), 0.005 * (rate[1:] + rate[:-1]), rtol=0.0, atol=2e-4, equal_nan=False)


def test_friction_step_comes_at_its_time():
    recording = drive(minutes=2.0, friction=FrictionCourse.step(4.0, 12.5, 60.0), seed=2)
    level, time = recording["truth_friction_torque"].values, recording["truth_friction_torque"].time
    assert np.all(level[time < 60.0] == 4.0)
    assert np.all(level[time >= 60.0] == 12.5)
    resistance = np.abs(recording["truth_friction_resistance"].values)
    assert np.max(resistance[time < 60.0]) <= 4.0
    assert np.max(resistance) == pytest.approx(12.5, rel=0.02)


def test_measured_is_truth_with_noise_and_bias():
    truth = drive(minutes=2.0, seed=4, sensors=IDEAL)
    measured = drive(minutes=2.0, seed=4)
    sensors = SensorSet.production()
    for name in CANONICAL:
        error = measured[name].values - truth[name].values
        noise = math.hypot(sensors[name].noise, sensors[name].quantum / math.sqrt(12.0))
        assert np.mean(error) == pytest.approx(sensors[name].bias, abs=5.0 * noise / math.sqrt(len(error)))
        assert np.std(error) == pytest.approx(noise, rel=0.03)


def test_sensor_rates_give_each_channel_its_own_stamps():
    sensors = IDEAL.with_sensors({"yaw_rate": Sensor(rate=50.0), "driver_torque": Sensor(rate=1000.0)})
    recording = drive(minutes=1.1, seed=0, sensors=sensors)
    assert len(recording["yaw_rate"].values) == 3_300
    assert len(recording["driver_torque"].values) == 66_000
    assert len(recording["motor_torque"].values) == 6_600
    reference = drive(minutes=1.1, seed=0, sensors=IDEAL)
    assert np.array_equal(recording["yaw_rate"].values, reference["yaw_rate"].values[::2])
    assert np.array_equal(recording["driver_torque"].values[::10], reference["driver_torque"].values)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"minutes": 0.0}, "positive duration"),
        ({"minutes": math.nan}, "positive duration"),
        ({"friction": -1.0}, "not negative"),
    ],
)
def test_wrong_options_are_refused_in_a_sentence(options, message):
    with pytest.raises(ParameterError, match=message):
        drive(**({"minutes": 0.1, "seed": 0} | options))


def test_metadata_show_seed_and_parameters(healthy):
    assert healthy.metadata["seed"] == 1
    assert healthy.metadata["friction"]["levels"] == (4.0,)
    assert healthy.metadata["vehicle"]["chassis.mass"] == 1600.0
    assert healthy.metadata["vehicle"]["steering.friction.level"] == 4.0
    assert healthy.metadata["sensors"]["driver_torque"]["bias"] == 0.05


def test_a_chosen_road_is_driven():
    recording = drive(minutes=2.0, seed=0, roads=(City(),))
    assert recording["vehicle_speed"].values.max() < 14.5


def resistance(recording):
    steering = EpsCar().steering
    gear, damping = steering.motor.ratio, steering.damping + steering.motor.ratio**2 * steering.motor.damping
    rate = recording["steering_wheel_rate"].values
    return rate, recording["driver_torque"].values + gear * recording["motor_torque"].values - damping * rate


def loop_friction(recording):
    """Friction from the work over the closed turn, Mohtat et al., eqs (15) to (17)."""
    rate, torque = resistance(recording)
    assert np.allclose(np.diff(recording["steering_wheel_rate"].time), 0.01)
    return np.sum(torque * rate) / np.sum(np.abs(rate))


@pytest.mark.parametrize("hoist", [True, False])
def test_lock_to_lock_spans_570_degrees_right_first(hoist):
    recording = lock_to_lock(4.0, hoist)
    angle = np.degrees(recording["steering_wheel_angle"].values)
    assert angle.min() == pytest.approx(-570.0, abs=2.0)
    assert angle.max() == pytest.approx(570.0, abs=2.0)
    assert np.argmin(angle) < np.argmax(angle)
    assert abs(angle[-1]) < 2.0
    assert not np.any(recording["truth_sideslip_angle"].values)


@lru_cache(maxsize=8)
def turned(friction, hoist):
    return loop_friction(lock_to_lock(friction, hoist, sensors=IDEAL))


@pytest.mark.parametrize("hoist", [True, False])
@pytest.mark.parametrize("added", [1.5, pytest.param(4.0, marks=pytest.mark.slow), 8.5])
def test_lock_to_lock_shows_the_added_friction(hoist, added):
    base = turned(4.0, hoist)
    assert turned(4.0 + added, hoist) - base == pytest.approx(added, abs=0.1)
    assert hoist == (base < 4.05)


def test_width_of_the_hysteresis_loop_is_twice_the_friction():
    recording = lock_to_lock(8.0, hoist=True, sensors=IDEAL)
    rate, torque = resistance(recording)
    middle = np.abs(recording["steering_wheel_angle"].values) < 1.0
    width = np.mean(torque[middle & (rate > 0.5)]) - np.mean(torque[middle & (rate < -0.5)])
    assert width == pytest.approx(16.0, abs=0.05)


def test_lock_to_lock_needs_a_rate():
    with pytest.raises(ParameterError, match="positive rate"):
        lock_to_lock(4.0, hoist=True, rate=0.0)
