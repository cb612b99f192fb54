import numpy as np
import pytest

from ground.faults.car_stand_in import SENSORS, Car, Steering
from tierod.core.errors import ParameterError
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod_lab.ground.faults import (
    AtDistance,
    AtTime,
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
    TorqueLoss,
    TotalLoss,
    When,
    Within,
)
from tierod_lab.ground.integration import Varied
from tierod_lab.ground.recorder import channel_names

SECONDS = 10.0
PIECE = 50


def make(*faults, seed=0, seconds=SECONDS):
    return Schedule(faults, Car(), SENSORS, seed, seconds)


def drive(schedule, speed=lambda time: 10.0, curvature=lambda time: 0.02 * np.sin(time), piece=PIECE, car=None):
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
    [
        TotalLoss(),
        Stuck(),
        Stuck(1.0),
        Offset(0.5),
        Gain(-1.0),
        Noise(0.3),
        Spikes(3.0, rate=2.0),
        DropOut(0.5, repeat=True),
        Intermittent(Stuck(), 0.3, 0.3),
        Intermittent(Noise(0.3), 0.3, 0.3),
    ],
    ids=lambda behaviour: type(behaviour).__name__,
)
def test_a_loop_and_the_recording_see_the_same_fault(behaviour):
    schedule = make(Fault("driver_torque", behaviour, AtTime(3.0), 4.0))
    time, outputs = drive(schedule)
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


def test_a_prefix_takes_one_of_both_places():
    recorded, looped = make(Fault("sensor.driver_torque", Offset(1.0))), make(Fault("loop.driver_torque", Offset(1.0)))
    time, values = np.arange(10) / 100.0, np.zeros(10)
    assert recorded.inputs(time) == {}
    assert recorded.on_channel("driver_torque", time, values)[1].all()
    assert looped.inputs(time)["ports.driver_torque.offset"].all()
    assert not looped.on_channel("driver_torque", time, values)[1].any()


def test_several_faults_of_one_element_are_applied_in_order():
    schedule = make(Fault("driver_torque", Offset(1.0)), Fault("driver_torque", Gain(2.0), AtTime(5.0)))
    time, outputs = drive(schedule)
    expected = np.where(time < 5.0, torque(time) + 1.0, 2.0 * (torque(time) + 1.0))
    np.testing.assert_allclose(outputs["motor_torque"], 2.0 * expected, atol=1e-12)
    _, recorded = schedule.on_channel("driver_torque", time[::10], torque(time[::10]))
    np.testing.assert_allclose(recorded, expected[::10], atol=1e-12)


HELD = {
    "offset stuck": (
        Fault("driver_torque", Offset(1.0), AtTime(2.0)),
        Fault("driver_torque", Stuck(), AtTime(3.0), 3.0),
    ),
    "offset of what is stuck": (
        Fault("driver_torque", Offset(1.0), AtTime(4.0), 3.0),
        Fault("driver_torque", Stuck(), AtTime(3.0), 3.0),
    ),
    "stuck offset": (
        Fault("driver_torque", Stuck(), AtTime(3.0), 3.0),
        Fault("driver_torque", Offset(1.0), AtTime(4.0), 3.0),
    ),
    "drift stuck": (Fault("driver_torque", Drift(1.0), AtTime(1.0)), Fault("driver_torque", Stuck(), AtTime(2.5), 2.5)),
    "gain drop-out": (
        Fault("driver_torque", Gain(3.0), AtTime(2.0), 2.0),
        Fault("driver_torque", DropOut(0.5, repeat=True)),
    ),
    "stuck stuck": (
        Fault("driver_torque", Stuck(), AtTime(1.0), 4.0),
        Fault("driver_torque", Stuck(), AtTime(3.0), 4.0),
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
    _, outputs = drive(schedule, piece=piece)
    stamps = np.arange(1000) / 100.0
    _, recorded = schedule.on_channel("driver_torque", stamps, torque(stamps))
    # What is held in the loop is up to 10 ms younger than the last frame, and up to tripled here.
    np.testing.assert_allclose(outputs["motor_torque"][::10] / 2.0, recorded, atol=0.065)


def test_what_is_stuck_from_the_beginning_stays_at_its_first_value():
    schedule = make(Fault("driver_torque", Stuck()))
    time, outputs = drive(schedule)
    np.testing.assert_allclose(outputs["motor_torque"], 8.0, atol=1e-12)
    assert (schedule.on_channel("driver_torque", time[::10], torque(time[::10]))[1] == 4.0).all()


def test_parameters_and_what_is_around_the_car():
    schedule = make(
        Fault("steering.level", Step(6.0), AtTime(2.0)),
        Fault("road.curvature", Gain(3.0), AtTime(4.0), 1.0),
        Fault("demand.speed", Step("72 km/h"), AtTime(6.0)),
    )
    time, outputs = drive(schedule)
    curvature = np.where((time >= 4.0) & (time < 5.0), 0.06, 0.02) * np.sin(time)
    np.testing.assert_allclose(outputs["driver_torque"], 100.0 * curvature + np.where(time < 2.0, 4.0, 6.0), atol=1e-12)
    np.testing.assert_allclose(outputs["vehicle_speed"], np.where(time < 6.0, 10.0, 20.0))


def test_surroundings_need_to_know_the_course():
    with pytest.raises(ParameterError, match="give `usual`"):
        make(Fault("road.curvature", Gain(3.0))).inputs(np.arange(3.0))


def test_one_fault_may_have_several_effects():
    schedule = make(
        Fault("steering.level", Step(6.0), AtTime(2.0), 3.0, "worn", also=(Effect("actuator.motor_torque", Gain(0.5)),))
    )
    time, outputs = drive(schedule)
    during = (time >= 2.0) & (time < 5.0)
    level = 100.0 * 0.02 * np.sin(time) + np.where(during, 6.0, 4.0)
    np.testing.assert_allclose(outputs["motor_torque"], np.where(during, 1.0, 2.0) * level, atol=1e-12)
    windows = schedule.windows
    assert [(each["name"], each["element"], each["behaviour"]) for each in windows] == [
        ("worn", "steering.level", "step"),
        ("worn", "motor_torque", "gain"),
    ]
    assert [(each["start"], each["end"]) for each in windows] == [(2.0, 5.0)] * 2


def test_a_condition_begins_a_fault_with_the_next_piece():
    schedule = make(Fault("steering.level", Step(6.0), When("vehicle_speed > 18 km/h", 0.5), 2.0))
    assert schedule.pending
    assert schedule.windows[0]["start"] is None
    time, outputs = drive(schedule, speed=lambda time: 2.0 * time)
    assert not schedule.pending
    start = schedule.windows[0]["start"]
    assert start == pytest.approx(3.0 + 1e-3, abs=PIECE * 1e-3)
    during = (time >= start - 1e-9) & (time < start + 2.0 - 1e-9)
    np.testing.assert_allclose(outputs["driver_torque"] - torque(time), np.where(during, 2.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("piece", [1, 20, 500])
def test_a_condition_has_to_hold_without_a_break(piece):
    schedule = make(Fault("steering.level", Step(6.0), When("|yaw_rate| > 0.1 rad/s and vehicle_speed < 11", 0.7)))
    # Above 0.1 for 0.45 s only around 1 s, and for 1.05 s from 4.0 s on.
    drive(
        schedule,
        curvature=lambda time: np.where((time > 1.0) & (time < 1.45) | (time > 4.0) & (time < 5.05), -0.02, 0.0),
        piece=piece,
    )
    assert schedule.windows[0]["start"] == pytest.approx(4.7, abs=piece * 1e-3 + 2e-3)


def test_a_condition_that_never_comes():
    schedule = make(Fault("driver_torque", Gain(2.0), When("vehicle_speed > 50 m/s")))
    drive(schedule)
    assert schedule.pending
    assert schedule.windows[0]["end"] is None
    assert (schedule.on_channel("driver_torque", np.arange(3.0), np.ones(3))[1] == 1.0).all()


def test_a_fault_at_a_distance():
    schedule = make(Fault("steering.level", Step(6.0), AtDistance(42.0)))
    drive(schedule)
    assert schedule.windows[0]["start"] == pytest.approx(4.2, abs=PIECE * 1e-3 + 2e-3)


def test_a_random_time_is_drawn_within_its_window():
    starts = [
        make(Fault("yaw_rate", TotalLoss(), Within(2.0, 6.0)), seed=seed).windows[0]["start"] for seed in range(300)
    ]
    assert min(starts) >= 2.0
    assert max(starts) <= 6.0
    assert np.mean(starts) == pytest.approx(4.0, abs=0.25)
    assert np.std(starts) == pytest.approx(4.0 / np.sqrt(12.0), rel=0.1)


def test_the_same_seed_gives_the_same_faults_and_others_do_not_move_them():
    noise = Fault("driver_torque", Noise(0.3), Within(1.0, 5.0))
    other = Fault("yaw_rate", Spikes(1.0))
    first, second = drive(make(noise)), drive(make(other, noise))
    assert np.array_equal(first[1]["motor_torque"], second[1]["motor_torque"])
    assert not np.array_equal(first[1]["motor_torque"], drive(make(noise, seed=1))[1]["motor_torque"])
    twice = make(noise, noise)
    assert twice.windows[0]["start"] != twice.windows[1]["start"]


def test_the_pieces_of_a_run_do_not_matter():
    faults = (Fault("driver_torque", Intermittent(Noise(0.3)), AtTime(1.234)), Fault("steering.level", Gain(1.1)))
    assert np.array_equal(drive(make(*faults))[1]["motor_torque"], drive(make(*faults), piece=400)[1]["motor_torque"])


def test_what_is_known_afterwards():
    schedule = make(
        Fault("motor_torque", TorqueLoss(0.5), AtTime(1.0), 100.0, "half"), Fault("yaw_rate", Offset("1 deg/s"))
    )
    half, offset = schedule.provenance
    assert half == {
        "name": "half",
        "element": "motor_torque",
        "behaviour": {"kind": "torque-loss", "share": 0.5},
        "start": 1.0,
        "end": SECONDS,
        "targets": ["actuator motor_torque"],
        "trigger": {"kind": "at-time", "time": 1.0},
    }
    assert offset["behaviour"]["size"] == pytest.approx(np.radians(1.0))
    assert offset["name"] == "yaw_rate offset"


def test_no_fault_is_nothing():
    schedule = make()
    assert schedule.parameters == ()
    assert not schedule.pending
    assert schedule.inputs(np.arange(3.0)) == {}
    assert schedule.windows == ()


def test_the_parameter_of_the_car_as_it_was_drawn_counts():
    car = Car(Steering(level=5.0))
    schedule = Schedule([Fault("steering.level", Gain(2.0))], car, SENSORS, 0, SECONDS)
    assert (schedule.inputs(np.arange(3.0))["parameters.steering.level"] == 10.0).all()
