"""The plant here is the wheel's equation integrated by hand in NumPy, with its own numbers."""

from dataclasses import replace

import numpy as np
import pytest

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


def test_before_the_first_sample_nothing_is_known():
    block = monitor()
    _, output = block.step(block.init(), block.Sample(np.nan, np.nan))
    assert output.hands == UNCERTAIN
    assert output.log_likelihood_ratio == 0.0


def test_it_learns_what_the_vehicle_file_has_wrong():
    samples = recorded(20.0, 90.0, 90.0, offset=0.04, inertia=1.03 * INERTIA)
    output = scan(monitor(), samples)
    assert output["inertia_error"][-1] == pytest.approx(0.03 * INERTIA, rel=0.2)
    assert output["torque_offset"][-1] == pytest.approx(0.04, abs=2e-3)
    assert np.all(output["hands"][6000:] == OFF)


def test_a_steady_wheel_and_noise_alone_identify_no_inertia():
    draw = np.random.default_rng(3)
    samples = np.column_stack([1e-4 * draw.standard_normal(200_000), 0.01 * draw.standard_normal(200_000)])
    assert abs(scan(monitor(), samples)["inertia_error"][-1]) < 0.002 * INERTIA


def test_broken_samples_decide_nothing():
    samples = recorded(8.0, 90.0, 90.0)
    samples[5000, 0] += 1.0
    samples[6500:6520] = np.nan
    hands = scan(monitor(), samples)["hands"]
    assert not np.any(hands == ON)
    assert hands[-1] == OFF


def test_after_a_long_gap_nothing_is_known_until_there_is_evidence_again():
    samples = recorded(8.0, 90.0, 90.0)
    samples[5000:5300] = np.nan
    samples[5300:, 0] += 2.0
    hands = scan(monitor(), samples)["hands"]
    assert hands[5050] == OFF
    assert hands[5250] == hands[5310] == UNCERTAIN
    assert first(hands, OFF, 5.3) < 0.8
    assert not np.any(hands == ON)


def test_higher_thresholds_decide_later():
    samples = recorded(10.0, 5.0, 8.0)
    careful = replace(monitor(), to_off=replace(monitor().to_off, threshold=70.0, ceiling=70.0))
    delays = [first(scan(each, samples)["hands"], OFF, 8.0) for each in (monitor(), careful)]
    assert delays[0] < delays[1]


def test_what_is_learnt_beyond_belief_is_forgotten():
    """A hand that pulls ever harder, slowly, must not become an offset of the sensor."""
    samples = recorded(40.0, 90.0, 90.0)
    samples[:, 1] += np.interp(np.arange(40_000) * STEP, [10.0, 40.0], [0.0, 0.6])
    output = scan(monitor(), samples)
    assert np.max(np.abs(output["torque_offset"])) <= monitor().greatest_offset
    assert not np.any(output["hands"][30_000:] == OFF)
