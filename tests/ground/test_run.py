"""What is foreseen of a car's way has no jumps, and is right for a steady acceleration."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground import EpsCar, Scatter, SensorSet, SingleTrack, run
from tierod_lab.ground.courses import Start
from tierod_lab.ground.courses.natural import NaturalDrive
from tierod_lab.ground.courses.open_loop import SineSteer, StepSteer
from tierod_lab.ground.faults import AtTime, Fault, Gain, Offset, Stuck, trigger_of
from tierod_lab.ground.faults import Step as Jump
from tierod_lab.ground.run import Foresight
from tierod_lab.ground.steering.friction import MaxwellSlip

CAR = EpsCar(chassis=SingleTrack())
FEW = SensorSet.production().only(("steering_wheel_angle", "driver_torque", "motor_torque", "yaw_rate"))
IDEAL = SensorSet.ideal().only(("steering_wheel_angle", "driver_torque", "motor_torque", "yaw_rate"))
DRIVE = NaturalDrive(name="some roads", seed=3, time=60.0)


@dataclass(frozen=True)
class Turn:
    column: str = "demand.steering_wheel_angle"
    value: float = 0.3
    speed: float = 15.0
    name: str = "turn"
    duration: float = 5.0

    @property
    def start(self):
        return Start(self.speed)

    def columns(self, time, distance, speed, ahead):
        return {"demand.speed": np.full(len(time), self.speed), self.column: np.full(len(time), self.value)}


def test_a_run_gives_measured_channels_and_the_truth_beside_them():
    recording = run(CAR, DRIVE, 10.0, seed=1, sensors=FEW).recording
    for name in FEW.sensors:
        assert len(recording[name].values) == 1000
        assert np.std(recording[name].values - recording[f"truth_{name}"].values) > 0.0
    assert recording["truth_speed"].unit == "m/s"
    assert recording["truth_friction_torque"].unit == "N*m"
    assert recording.metadata["car"] == "EpsCar"
    assert recording.metadata["course"] == "some roads"
    assert recording.metadata["vehicle"]["chassis.mass"] == 1600.0


def test_the_same_seed_gives_the_same_bits():
    faults = [Fault("yaw_rate", Gain(2.0), AtTime(4.0))]
    one, same, other = (
        run(CAR, DRIVE, 8.0, seed=seed, sensors=FEW, faults=faults, scatter=Scatter()).recording for seed in (7, 7, 8)
    )
    for name in one.names:
        assert np.array_equal(one[name].values, same[name].values)
    assert not np.array_equal(one["driver_torque"].values, other["driver_torque"].values)


def test_how_a_run_is_cut_moves_the_course_by_less_than_the_eye_sees(monkeypatch):
    usual = run(CAR, DRIVE, 40.0, sensors=IDEAL).recording
    module = __import__("tierod_lab.ground.run", fromlist=["PIECE"])
    monkeypatch.setattr(module, "LOOK", 0.01)
    fine = run(CAR, DRIVE, 40.0, sensors=IDEAL).recording
    angle = fine["steering_wheel_angle"].values
    assert np.max(np.abs(usual["steering_wheel_angle"].values - angle)) < 0.02 * np.max(np.abs(angle))


def test_a_run_that_diverges_keeps_what_was_good():
    course = Turn(value=0.4)
    outcome = run(CAR, course, sensors=FEW, faults=[Fault("chassis.yaw_inertia", Jump(1e-3), AtTime(2.0))])
    assert 2.0 <= outcome.diverged_at < 3.5
    recording = outcome.recording
    assert recording.metadata["diverged_at"] == outcome.diverged_at
    for name in recording.names:
        assert np.isfinite(recording[name].values).all()
        assert recording[name].time[-1] == pytest.approx(outcome.diverged_at, abs=0.02)


def test_a_run_that_is_lost_from_the_beginning_is_empty():
    outcome = run(CAR, Turn(speed=200.0), sensors=FEW)
    assert outcome.diverged_at == 0.0
    assert all(len(outcome.recording[name].values) == 0 for name in outcome.recording.names)


def test_leaving_the_limits_for_a_moment_is_leaving_them(monkeypatch):
    module = __import__("tierod_lab.ground.run", fromlist=["LIMITS"])
    monkeypatch.setattr(module, "LOOK", 5.0)
    course = SineSteer(name="sine", speed=20.0, settle=1.0, frequency=1.0, rest=3.0)
    yaw_rate = run(CAR, course, sensors=IDEAL).recording["truth_yaw_rate"]
    limit = 0.5 * np.max(yaw_rate.values)
    monkeypatch.setattr(module, "LIMITS", {"yaw_rate": limit})
    left = yaw_rate.time[np.argmax(yaw_rate.values >= limit)]
    assert run(CAR, course, sensors=IDEAL).diverged_at == pytest.approx(left, abs=0.0101)


def test_a_fault_waits_for_its_condition():
    course = StepSteer(name="step", speed=20.0, settle=1.0, hold=3.0, rest=1.0)
    fault = Fault("yaw_rate", Offset(0.5), trigger_of("yaw_rate > 5 deg/s"), duration=1.0)
    outcome = run(CAR, course, sensors=IDEAL, faults=[fault])
    truth, measured = (outcome.recording[name] for name in ("truth_yaw_rate", "yaw_rate"))
    wrong = measured.time[np.abs(measured.values - truth.values) > 0.4]
    crossed = truth.time[np.argmax(truth.values > math.radians(5.0))]
    (window,) = outcome.windows
    assert crossed <= window["start"] <= crossed + 0.06
    assert wrong[0] == pytest.approx(window["start"], abs=0.011)
    assert wrong[-1] == pytest.approx(window["end"], abs=0.011)


def test_a_parameter_and_a_surrounding_change_while_driving():
    faults = [
        Fault("steering.friction.level", Jump("12.5 N*m"), AtTime(2.0)),
        Fault("road.adhesion_left", Jump(0.4), AtTime(3.0)),
    ]
    recording = run(CAR, Turn(value=0.1), sensors=IDEAL, faults=faults).recording
    level, adhesion = recording["truth_friction_torque"], recording["truth_road_friction"]
    assert np.array_equal(level.values, np.where(level.time < 2.0 - 1e-9, 4.0, 12.5))
    assert adhesion.values == pytest.approx(np.where(adhesion.time < 3.0 - 1e-9, 1.0, 0.7))


def test_an_item_of_a_tuple_of_parameters_changes_while_driving():
    friction = replace(CAR.steering.friction, law=MaxwellSlip())
    car = replace(CAR, steering=replace(CAR.steering, friction=friction))
    fault = Fault("steering.friction.law.shares.0", Jump(0.0), AtTime(2.0))
    fault_free, slack = (run(car, Turn(), sensors=IDEAL, faults=faults).recording for faults in ((), [fault]))
    torque = slack["truth_friction_resistance"]
    early = torque.time < 2.0 - 1e-9
    assert np.array_equal(torque.values[early], fault_free["truth_friction_resistance"].values[early])
    assert not np.array_equal(torque.values, fault_free["truth_friction_resistance"].values)


def test_a_fault_of_a_signal_that_the_car_reads_changes_the_drive():
    course = SineSteer(name="weave", speed=20.0, periods=3)
    fault_free = run(CAR, course, sensors=IDEAL).recording
    stuck = run(CAR, course, sensors=IDEAL, faults=[Fault("driver_torque", Stuck(), AtTime(5.0))]).recording
    before = fault_free["motor_torque"].time < 5.0
    assert np.array_equal(fault_free["motor_torque"].values[before], stuck["motor_torque"].values[before])
    assert np.max(np.abs(fault_free["motor_torque"].values - stuck["motor_torque"].values)) > 0.02
    held = stuck["driver_torque"].values[~before]
    assert np.ptp(held) == 0.0


def test_sensors_of_what_the_car_lacks_are_left_out():
    sensors = FEW.with_sensors({"motor_current_alpha": SensorSet.ideal()["motor_current_alpha"]})
    assert "motor_current_alpha" not in run(CAR, Turn(), sensors=sensors).recording.names


def test_a_course_says_with_what_speed_to_begin():
    for speed in (0.0, 12.0):
        recording = run(replace(CAR), Turn(speed=speed), 0.5, sensors=IDEAL).recording
        assert recording["truth_speed"].values[0] == speed


@pytest.mark.parametrize(
    ("course", "seconds", "message"),
    [
        (Turn(), math.inf, "positive, finite duration"),
        (Turn(), -1.0, "positive, finite duration"),
        (Turn(), 4e-4, "at least 0.001 s, not 0.0004 s"),
        (Turn(column="demand.steering_weel_angle"), 1.0, "sets 'demand.steering_weel_angle'.*steering_wheel_angle"),
    ],
)
def test_wrong_options_are_refused_in_a_sentence(course, seconds, message):
    with pytest.raises(ParameterError, match=message):
        run(CAR, course, seconds)


def test_parts_keep_the_step_of_their_car():
    with pytest.raises(ParameterError, match=r"computed every 0.0005 s, but its 'driver.step_time' is 0.001 s"):
        run(replace(CAR, step_time=5e-4), Turn(), sensors=IDEAL)
    with pytest.raises(ParameterError, match="'step_time' is 0.005 s, but has to be 1e-05 to 0.002 s"):
        run(replace(CAR, step_time=5e-3), Turn(), sensors=IDEAL)


def test_progress_is_reported():
    result = []
    run(CAR, Turn(), 1.0, sensors=IDEAL, progress=result.append)
    assert result == sorted(result)
    assert result[-1] == 1.0


LOOK = 0.2
TIME = np.linspace(0.0, LOOK, 50, endpoint=False)


def pieces(foresight, distance_at, speed_at, count):
    found = []
    for number in range(count):
        if number:
            now = number * LOOK
            foresight.look(distance_at(now), speed_at(now), LOOK)
        found.append(foresight.over(TIME, LOOK))
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def test_a_steady_speed_is_foreseen_exactly():
    distance, speed = pieces(Foresight(0.0, 8.0), lambda t: 8.0 * t, lambda t: 8.0, 4)
    assert distance == pytest.approx(8.0 * np.arange(200) * LOOK / 50)
    assert np.all(speed == 8.0)


def test_a_steady_braking_is_foreseen_from_the_third_look_on():
    distance, speed = pieces(Foresight(0.0, 10.0), lambda t: 10.0 * t - 1.5 * t * t, lambda t: 10.0 - 3.0 * t, 5)
    time = np.arange(250) * LOOK / 50
    assert distance[150:] == pytest.approx(10.0 * time[150:] - 1.5 * time[150:] ** 2)
    assert speed[150:] == pytest.approx(10.0 - 3.0 * time[150:])


def test_a_look_that_corrects_makes_no_jump():
    rng = np.random.default_rng(1)
    speeds = 8.0 + np.cumsum(rng.normal(0.0, 0.5, 20))
    places = np.concatenate([[0.0], np.cumsum(speeds[:-1] * LOOK)])

    def at(values):
        return lambda now: float(values[round(now / LOOK)])

    distance, speed = pieces(Foresight(0.0, float(speeds[0])), at(places), at(speeds), 20)
    assert np.abs(np.diff(distance, 2)).max() < 0.01
    assert np.abs(np.diff(speed)).max() < 0.15
    assert np.abs(np.diff(places, 2)).max() > 0.1  # the looks themselves jump
