from __future__ import annotations

import numpy as np
import pytest

from ground.rigs import SENSORS, Car
from tierod.core.errors import ParameterError
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod.core.recording import Channel, Recording
from tierod_lab.ground import SensorSet, run
from tierod_lab.ground.cars.road_cars import DemonstratorCar
from tierod_lab.ground.courses import load
from tierod_lab.ground.faults import (
    AtTime,
    Delay,
    Drift,
    DropOut,
    Effect,
    Fault,
    Gain,
    Intermittent,
    Noise,
    Offset,
    Schedule,
    Spikes,
    Step,
    Stuck,
    TotalLoss,
    Within,
    injected,
)
from tierod_lab.ground.integration import Varied
from tierod_lab.ground.recorder import channel_names

SECONDS = 10.0
PIECE = 50


def make(*faults, seed=0, seconds=SECONDS):
    return Schedule(faults, Car(), SENSORS, seed, seconds)


def driven(schedule, speed=lambda time: 10.0, curvature=lambda time: 0.02 * np.sin(time), piece=PIECE, car=None):
    block = Varied(car or Car(), schedule.parameters) if schedule.parameters else car or Car()
    driven, memory = kernel(block), initial_memory(block)
    index = {name: column for column, name in enumerate(driven.graph.sample)}
    names = {name: columns[0] for name, columns in channel_names(block).items()}
    usual = {"demand.speed": speed, "road.curvature": curvature}
    rows, times = [], []
    for first in range(0, round(SECONDS * 1000), piece):
        time = np.arange(first, first + piece) * 1e-3
        samples = np.zeros((piece, len(index)))
        for name, column in index.items():
            if name.endswith(".gain"):
                samples[:, column] = 1.0
        if schedule.parameters:
            samples[:, index["parameters.steering.level"]] = 4.0
        for name, course in usual.items():
            samples[:, index[name]] = course(time)
        for name, values in schedule.inputs(time, lambda name: samples[:, index[name]]).items():  # noqa: B023
            samples[:, index[name]] = values
        outputs = np.empty((piece, len(driven.graph.output)))
        driven.scan(memory, samples, outputs, first)
        if schedule.pending:
            schedule.observe(time, {name: outputs[:, column] for name, column in names.items()})
        rows.append(outputs)
        times.append(time)
    values = np.concatenate(rows)
    return np.concatenate(times), {name: values[:, column] for name, column in names.items()}


def torque(time):
    return 100.0 * 0.02 * np.sin(time) + 4.0


@pytest.mark.parametrize(
    "behaviour",
    [TotalLoss(), Offset(0.5), Spikes(3.0, rate=2.0), DropOut(0.5, repeat=True), Intermittent(Stuck(), 0.3, 0.3)],
    ids=lambda behaviour: type(behaviour).__name__,
)
def test_a_loop_and_the_recording_see_the_same_fault(behaviour):
    schedule = make(Fault("driver_torque", behaviour, AtTime(3.0), 4.0))
    time, outputs = driven(schedule)
    stamps = np.arange(1000) / 100.0
    stamps, recorded = schedule.on_channel("driver_torque", stamps, torque(stamps))
    read = outputs["motor_torque"][np.rint(stamps * 1000).astype(int)] / 2.0
    np.testing.assert_allclose(outputs["driver_torque"], torque(time), atol=1e-12)
    if isinstance(behaviour, Stuck | DropOut | Intermittent):
        # What is held in the loop is up to 10 ms younger than the last frame.
        np.testing.assert_allclose(read, recorded, atol=0.021)
    else:
        np.testing.assert_allclose(read, recorded, atol=1e-12)
    fault_free = (time < 3.0) | (time >= 7.0)
    np.testing.assert_allclose(outputs["motor_torque"][fault_free], 2.0 * torque(time)[fault_free], atol=1e-12)
    assert np.abs(read - torque(stamps)).max() > 0.05


HELD = {
    "offset of what is stuck": (
        Fault("driver_torque", Offset(1.0), AtTime(4.0), 3.0),
        Fault("driver_torque", Stuck(), AtTime(3.0), 3.0),
    ),
    "drift stuck": (Fault("driver_torque", Drift(1.0), AtTime(1.0)), Fault("driver_torque", Stuck(), AtTime(2.5), 2.5)),
    "gain drop-out": (
        Fault("driver_torque", Gain(3.0), AtTime(2.0), 2.0),
        Fault("driver_torque", DropOut(0.5, repeat=True)),
    ),
}
ALONE = ("offset of what is stuck", "gain drop-out")
"""Where every sample is a piece of its own, each kind of what is held once; the others in the study."""


@pytest.mark.parametrize(
    ("name", "piece"),
    [
        *((name, piece) for name in HELD for piece in (50, 2500)),
        *(pytest.param(name, 1, marks=() if name in ALONE else pytest.mark.slow) for name in HELD),
    ],
)
def test_what_is_held_of_a_faulty_signal_is_the_same_in_the_loop(name, piece):
    schedule = make(*HELD[name])
    _, outputs = driven(schedule, piece=piece)
    stamps = np.arange(1000) / 100.0
    _, recorded = schedule.on_channel("driver_torque", stamps, torque(stamps))
    # What is held in the loop is up to 10 ms younger than the last frame, and up to tripled here.
    np.testing.assert_allclose(outputs["motor_torque"][::10] / 2.0, recorded, atol=0.065)


def test_one_fault_may_have_several_effects():
    schedule = make(
        Fault("steering.level", Step(6.0), AtTime(2.0), 3.0, "worn", also=(Effect("actuator.motor_torque", Gain(0.5)),))
    )
    time, outputs = driven(schedule)
    during = (time >= 2.0) & (time < 5.0)
    level = 100.0 * 0.02 * np.sin(time) + np.where(during, 6.0, 4.0)
    np.testing.assert_allclose(outputs["motor_torque"], np.where(during, 1.0, 2.0) * level, atol=1e-12)
    windows = schedule.windows
    assert [(each["name"], each["element"], each["behaviour"]) for each in windows] == [
        ("worn", "steering.level", "step"),
        ("worn", "motor_torque", "gain"),
    ]
    assert [(each["start"], each["end"]) for each in windows] == [(2.0, 5.0)] * 2


def test_the_same_seed_gives_the_same_faults_and_others_do_not_move_them():
    noise = Fault("driver_torque", Noise(0.3), Within(1.0, 5.0))
    other = Fault("yaw_rate", Spikes(1.0))
    first, second = driven(make(noise)), driven(make(other, noise))
    assert np.array_equal(first[1]["motor_torque"], second[1]["motor_torque"])
    assert not np.array_equal(first[1]["motor_torque"], driven(make(noise, seed=1))[1]["motor_torque"])
    twice = make(noise, noise)
    assert twice.windows[0]["start"] != twice.windows[1]["start"]


@pytest.mark.parametrize("behaviour", [TotalLoss(), Stuck(), Offset("5 deg/s"), Drift(0.1), Noise(0.2), Delay(0.1)])
def test_a_recording_with_an_injected_fault_is_that_of_a_run_with_the_fault(behaviour):
    car, course, sensors = DemonstratorCar(), load("short-round"), SensorSet.production()
    fault = Fault("sensor.yaw_rate", behaviour, AtTime(1.5), 1.0)
    healthy = run(car, course, 3.0, 5, sensors).recording
    faulty = run(car, course, 3.0, 5, sensors, [fault]).recording
    made = injected(healthy, [fault], sensors, 5)
    for name in healthy.names:
        np.testing.assert_array_equal(made[name].values, faulty[name].values)
    assert np.any(made["yaw_rate"].values != healthy["yaw_rate"].values)


def _recording() -> Recording:
    time = 100.0 + np.arange(500) / 50.0
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s"),
            "Brake_Light": Channel("Brake_Light", time, 0.0 * time, ""),
        }
    )


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (Fault("steering_wheel_angle", Offset(0.1)), "steering_wheel_angle"),
        (Fault("Brake_Light", Offset(0.1)), "Brake_Light"),
        (Fault("yaw_rate", Offset(0.1), AtTime(200.0)), "begin earlier"),
    ],
)
def test_what_is_not_recorded_cannot_fail(fault, said):
    with pytest.raises(ParameterError, match=said):
        injected(_recording(), [fault])
