"""The rule that ends control, and the controller with it."""

from dataclasses import replace

import numpy as np
import pytest

from controlled_column import CONTROL, STEP
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.design import run_length
from tierod.papers.column.control.intervention import DriverIntervention, Noise, SteeringController, Takeover, noise_of
from tierod.papers.column.control.reference import Sweep

RULE = DriverIntervention.design(Noise(0.05, 8.0), STEP, inertia_uncertainty=0.0014)


def run(hand_torque, request, acceleration=0.0, rule=RULE):
    hand_torque = np.asarray(hand_torque, float)
    rows = np.column_stack([hand_torque, np.broadcast_to(acceleration, hand_torque.shape), request])
    return scan(rule, rows)


def since(seconds, count=6000):
    return (np.arange(count) * STEP >= seconds - 1e-9).astype(float)


def test_noise_of_a_first_order_process_has_its_closed_form():
    random, pole, count = np.random.default_rng(0), 0.9, 400_000
    pushes, values = random.normal(size=count), np.zeros(count)
    for k in range(1, count):
        values[k] = pole * values[k - 1] + pushes[k]
    found = noise_of(values)
    assert found.deviation == pytest.approx(1.0 / np.sqrt(1.0 - pole**2), rel=0.02)
    assert found.correlated == pytest.approx((1.0 + pole) / (1.0 - pole), rel=0.1)


def test_the_drift_lies_half_way_and_the_threshold_finds_the_torque_within_the_delay():
    assert RULE.cusum.drift == 0.75
    hands = 1.0 * since(2.0)
    found = np.nonzero(run(hands, since(1.2))["found"])[0][0] * STEP - 2.0
    assert found == pytest.approx(Takeover().delay, abs=2.0 * STEP)


def test_noise_that_leaves_no_room_for_the_delay_is_refused():
    with pytest.raises(ParameterError, match=r"only after 0\.\d+ s if false ends are to be 10000 h apart"):
        DriverIntervention.design(Noise(0.2, 20.0), STEP)
    DriverIntervention.design(Noise(0.2, 20.0), STEP, Takeover(delay=0.5))


def test_false_ends_are_as_rare_as_the_run_length_says():
    asked = Takeover(hours=1.0 / 3600.0, delay=0.007)
    rule = DriverIntervention.design(Noise(0.4, 1.0), STEP, asked)
    rule = replace(rule, cusum=replace(rule.cusum, restart=True))
    values = asked.forgiven + 0.4 * np.random.default_rng(1).normal(size=1_000_000)
    sums = run(np.maximum(values, 0.0), np.ones(len(values)), rule=rule)["sum"]
    alarms = int((sums >= rule.cusum.threshold).sum())
    expected = run_length(0.25 / 0.4, rule.cusum.threshold / 0.4, sides="upper")
    assert len(values) / alarms == pytest.approx(expected, rel=0.15)
    assert expected > 1000.0


def test_a_grip_ends_control_and_a_new_request_with_still_hands_brings_it_back():
    hands = 2.0 * (since(2.0) - since(3.0))
    request = since(1.2) - since(3.2) + since(3.4) - since(3.6) + since(4.5)
    result = run(hands, request)
    allowed, time = result["allowed"], np.arange(6000) * STEP
    assert allowed[(time >= 1.2) & (time < 2.0)].all()
    assert result["found"].sum() == 1.0
    assert 2.0 <= time[result["found"] > 0.5][0] < 2.01
    assert not allowed[(time > 2.01) & (time < 4.499)].any()
    assert allowed[time > 4.501].all()


def test_a_request_that_stays_does_not_bring_control_back():
    assert not run(2.0 * (since(2.0) - since(2.5)), since(1.2))["allowed"][2100:].any()


def test_control_is_not_given_to_whoever_holds_the_wheel():
    assert not run(0.7 * since(0.0), since(1.5))["allowed"].any()
    assert not run(0.0 * since(0.0), since(0.5))["allowed"].any()


def test_single_values_above_the_quiet_torque_do_not_keep_control_away():
    twitch = 0.6 * (np.arange(6000) % 100 == 0)
    assert run(twitch, since(1.5))["allowed"][-1] == 1.0


def test_what_is_forgiven_never_ends_control_and_what_must_be_found_always_does():
    torque = np.where(since(1.5) > 0.5, 0.7, 0.0)
    assert run(torque, since(1.2))["allowed"][-1] == 1.0
    assert run(torque + 0.3 * since(1.5), since(1.2))["allowed"][-1] == 0.0


def test_what_a_wrong_inertia_feigns_is_forgiven():
    feigned = 0.0014 * 200.0
    torque = (0.7 + feigned) * since(1.5)
    assert run(torque, since(1.2), 200.0)["allowed"][-1] == 1.0
    assert run(torque, since(1.2), 0.0)["allowed"][-1] == 0.0


def test_hands_that_are_not_seen_end_control_after_the_delay():
    blind = np.where(since(2.0) > 0.5, np.nan, 0.0)
    allowed = run(blind, since(1.2))["allowed"]
    gone = np.nonzero(allowed[2000:] < 0.5)[0][0] * STEP
    assert gone == pytest.approx(Takeover().delay, abs=2.0 * STEP)
    assert not allowed[2100:].any()
    assert not run(np.full(6000, np.nan), since(1.5))["allowed"].any()


def test_a_few_samples_that_are_missing_do_not_end_control():
    gaps = np.where(np.arange(6000) % 100 < 5, np.nan, 0.0)
    assert run(gaps, since(1.5))["allowed"][1600:].all()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Takeover(torque=0.4),
        lambda: Takeover(forgiven=-0.1),
        lambda: Takeover(quiet_torque=0.0),
        lambda: Takeover(hours=0.0),
        lambda: Takeover(delay=0.0),
        lambda: DriverIntervention.design(Noise(0.0, 1.0), STEP),
        lambda: replace(RULE, inertia_uncertainty=-1.0),
        lambda: replace(RULE, cusum=replace(RULE.cusum, sides="both")),
        lambda: noise_of(np.zeros(5000)),
        lambda: noise_of(np.ones(3)),
    ],
)
def test_wrong_numbers_are_refused(wrong):
    with pytest.raises(ParameterError, match="expected|measure"):
        wrong()


CONTROLLER = SteeringController(CONTROL, DriverIntervention.design(Noise(0.05, 8.0), STEP))
COUNT = 3000


@pytest.fixture(scope="module")
def grip():
    """A wheel that stands still while a sweep is asked for; hands push from 2 s on."""
    time = np.arange(COUNT) * STEP
    reference = Sweep(start=1.0, stop=1.0).at(np.maximum(time - 1.2, 0.0))
    hands = np.where(time >= 2.0, 1.5, 0.0)
    rows = np.column_stack([np.zeros((COUNT, 5)), hands, *reference, (time >= 1.2).astype(float)])
    return time, scan(CONTROLLER, rows)


def test_control_acts_until_the_driver_is_found(grip):
    time, result = grip
    hold = result["control.hold"]
    assert hold[(time > 1.6) & (time < 2.0)].min() == 1.0
    found = time[result["driver.found"] > 0.5]
    assert len(found) == 1
    assert found[0] == pytest.approx(2.0 + 7.5 / 0.75 * STEP, abs=2.0 * STEP)
    gone = time[(time > 2.0) & (hold <= 0.0)][0]
    assert gone - found[0] == pytest.approx(CONTROL.limits.releasing, abs=2.0 * STEP)
    assert not result["control.motor_torque"][time > gone + 0.01].any()


def test_letting_go_is_smooth(grip):
    _, result = grip
    assert np.abs(np.diff(result["control.motor_torque"])).max() <= CONTROL.limits.rate * STEP * (1.0 + 1e-9)
