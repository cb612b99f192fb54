"""The default observer of a column: exactness, gaps, cars without gear or motor angle, parameters that do not fit."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.hands import OFF, ON, UNCERTAIN, HandsMonitor
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.vehicles import load

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

BENCH = load("column-bench")
KNOWN = BENCH.parameters_for(ColumnParameters)


@pytest.fixture(scope="module")
def observer():
    return ColumnObserver.of_vehicle(BENCH)


@pytest.mark.parametrize(("hands", "goal"), [("steps", 0.07), ("ramps", 0.04), ("free", 0.04)])
def test_torque_of_the_hands_within_its_goal(observer, hands, goal):
    measured, true = run(hands)
    found = scan(observer, measured)
    used = true["time"] > 0.5
    assert rms((found["hand_torque"] - true["hand_torque"])[used]) < goal
    assert rms((found["disturbance_torque"] - true["disturbance_torque"])[used]) < 0.018
    assert rms((found["steering_wheel_rate"] - true["steering_wheel_rate"])[used]) < 0.02
    assert found["nis"][used].mean() == pytest.approx(3.0, rel=0.05)
    np.testing.assert_array_equal(found["ready"][true["time"] > 0.2], 1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"steering_wheel_inertia": -0.035}, "steering_wheel_inertia of the column is -0.035"),
        ({"motor_damping": -0.01}, "unstable: eigenvalue"),
        ({"steering_wheel_damping": -2.0}, "unstable: eigenvalue .* 1/s in .*steering_wheel_rate"),
        ({"gear_inertia": 1e-7}, "too fast for its rate: eigenvalue"),
        ({"torsion_bar_stiffness": 0.0}, "torsion_bar_stiffness of the column is 0"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        ColumnObserver.of_parameters(replace(KNOWN, **change))


STEP = 1e-3
INERTIA, DAMPING = 0.035, 0.2286477177


def monitor():
    return HandsMonitor.of_vehicle(load("column-bench"), STEP)


def wheel(bar, hand, inertia=INERTIA, damping=DAMPING, fine=10):
    """Angle [rad] of a wheel under the torques [N*m] of bar and hands, straight between samples."""
    angle, rate, angles = 0.0, 0.0, []
    ends = np.column_stack([hand - bar, np.append((hand - bar)[1:], 0.0)])
    for before, after in ends:
        angles.append(angle)
        for part in range(fine):
            torque = before + (after - before) * (part + 0.5) / fine
            middle = rate + 0.5 * STEP / fine * (torque - damping * rate) / inertia
            rate += STEP / fine * (torque - damping * middle) / inertia
            angle += STEP / fine * middle
    return np.array(angles)


def recorded(seconds, on, off, seed=1, offset=0.0, **plant):
    """Samples of angle and torque with hands between two instants [s], and a motor that shakes the bar."""
    draw, time = np.random.default_rng(seed), np.arange(0.0, seconds, STEP)
    held = (time >= on) & (time < off)
    tremble = np.convolve(
        draw.standard_normal(len(time)), np.hanning(60) / np.sqrt(np.sum(np.hanning(60) ** 2)), "same"
    )
    hand = 0.15 * held * tremble
    bar = 0.4 * np.sin(2.0 * np.pi * 1.3 * time) + 0.2 * np.sin(2.0 * np.pi * 4.1 * time)
    angle = wheel(bar, hand, **plant) + 1.2e-4 * draw.standard_normal(len(time))
    return np.column_stack([angle, bar + offset + 0.01 * draw.standard_normal(len(time))])


def first(hands, state, after):
    """Seconds from an instant to the first sample of a state."""
    begin = round(after / STEP)
    return STEP * np.flatnonzero(hands[begin:] == state)[0]


def test_it_finds_hands_that_come_and_go():
    hands = scan(monitor(), recorded(12.0, 6.0, 9.0))["hands"]
    assert hands[0] == UNCERTAIN
    assert first(hands, OFF, 0.0) < 3.0  # neither offset nor inertia is known at first
    assert first(hands, ON, 6.0) < 0.3
    assert first(hands, OFF, 9.0) < 0.8
    assert not np.any(hands[:6000] == ON)
    assert not np.any(hands[6300:9000] == OFF)
    assert not np.any(hands[10_000:] == ON)
