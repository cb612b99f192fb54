"""The plant here is the wheel's equation integrated by hand in NumPy, with its own numbers."""

import numpy as np

from tierod.core.graph import scan
from tierod.monitors.driver_torque.hands import OFF, ON, UNCERTAIN, HandsMonitor
from tierod.vehicles import load

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


def test_after_a_long_gap_nothing_is_known_until_there_is_evidence_again():
    samples = recorded(8.0, 90.0, 90.0)
    samples[5000:5300] = np.nan
    samples[5300:, 0] += 2.0
    hands = scan(monitor(), samples)["hands"]
    assert hands[5050] == OFF
    assert hands[5250] == hands[5310] == UNCERTAIN
    assert first(hands, OFF, 5.3) < 0.8
    assert not np.any(hands == ON)
