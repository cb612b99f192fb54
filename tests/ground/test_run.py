"""Runs of a virtual car on a course: how they are cut, recorded, changed while driving, and lost."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground import EpsCar, SensorSet, SingleTrack, run
from tierod_lab.ground.courses.course import Start
from tierod_lab.ground.courses.manoeuvres import StepSteer
from tierod_lab.ground.courses.roads import NaturalDrive
from tierod_lab.ground.faults import AtTime, Fault, Offset, trigger_of
from tierod_lab.ground.faults import Step as Jump
from tierod_lab.ground.recorder import Recorder

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


def recorded(outputs, columns, instants, seconds, sizes):
    recorder = Recorder(columns, instants, 1e-3, seconds)
    start = 0
    for size in sizes:
        recorder.add(outputs[start : start + size])
        start += size
    assert start == len(outputs)
    return recorder.truths()


def plant(seconds=30.0):
    time = np.arange(round(seconds * 1e3)) * 1e-3
    return time, np.column_stack([np.sin(time), time**2])


def test_channels_are_read_at_their_own_instants_whatever_the_pieces():
    _, outputs = plant()
    instants = {"yaw_rate": np.arange(0.0, 29.9, 0.0137) + 0.00025, "vehicle_speed": np.arange(0.0, 30.0, 0.5)}
    columns = {"yaw_rate": [0], "vehicle_speed": [1]}
    one = recorded(outputs, columns, instants, 30.0, [30_000])
    many = recorded(outputs, columns, instants, 30.0, [200] * 149 + [7, 193])
    for name, values in one.items():
        assert np.array_equal(values, many[name])
    assert one["yaw_rate"] == pytest.approx(np.sin(instants["yaw_rate"]), abs=1e-6)
    assert np.array_equal(one["vehicle_speed"], (instants["vehicle_speed"]) ** 2)
