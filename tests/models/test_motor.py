"""The sampled motor against closed forms: a winding alone, a rotor driven or under torque, an inverter before it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.models.stator_frame_motor import (
    CommandedMotor,
    CommandedMotorParameters,
    SampledMotorParameters,
    StatorFrameMotor,
)
from tierod.physics.motor import StatorVector, lost_voltage

MOTOR = SampledMotorParameters(0.05, 1e-4, 0.01, 4.0, 1e-4, 1e-4, 1e-4)
HEAVY = replace(MOTOR, motor_inertia=1e9, motor_damping=0.0)
REST = StatorFrameMotor.State(*[0.0] * 7)
NOTHING = StatorFrameMotor.Input(0.0, 0.0, 0.0, 0.0)


def after(state, steps, p, given=NOTHING):
    for _ in range(steps):
        state = StatorFrameMotor.transition(state, given, p)
    return state


def test_the_current_of_a_winding_decays_with_its_time_constant():
    begun = REST._replace(current_alpha=10.0, current_beta=-4.0)
    found = after(begun, 40, HEAVY)
    expected = math.exp(-40 * 1e-4 * 0.05 / 1e-4)
    assert found.current_alpha / 10.0 == pytest.approx(expected, rel=1e-3)
    assert found.current_beta / -4.0 == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("speed", "error"), [(100.0, 2e-4), (750.0, 0.02)])
def test_a_driven_rotor_sends_the_current_of_its_back_emf_through_a_short(speed, error):
    found = after(REST._replace(speed=speed), 2000, HEAVY)
    rate = 4.0 * speed
    rotor = np.exp(4j * found.angle)
    expected = -1j * rate * 0.01 * rotor / (0.05 + 1j * rate * 1e-4)
    assert found.angle == pytest.approx(speed * 0.2, rel=1e-6)
    assert abs(found.current_alpha + 1j * found.current_beta - expected) < error * abs(expected)


def test_current_across_the_flux_turns_the_rotor_against_its_load():
    begun = REST._replace(current_beta=10.0, load_torque=0.2)
    slow = replace(MOTOR, sample_time=1e-7)
    found = after(begun, 1, slow)
    # 3/2 z_p psi i_q less the load, over the inertia.
    assert found.speed / 1e-7 == pytest.approx((1.5 * 4.0 * 0.01 * 10.0 - 0.2) / 1e-4, rel=1e-4)


VALUES = (0.05, 1e-4, 0.01, 4.0, 1e-4, 1e-4)
INVERTER = CommandedMotorParameters(*VALUES, inverter_voltage_loss=0.8, inverter_knee_current=2.0)
FED = SampledMotorParameters(*VALUES)
COMMAND = StatorFrameMotor.Input(3.0, -1.0, 0.0, 0.0)


@pytest.mark.parametrize("current", [(8.0, 3.0), (0.4, -0.3), (-1.5, 6.0)])
def test_it_is_a_motor_with_the_loss_taken_from_the_command(current):
    state = CommandedMotor.State(*current, 40.0, 0.3, 0.1, 0.1, -0.02, 0.8, math.log(0.5))
    found = CommandedMotor.transition(state, COMMAND, INVERTER)
    lost = lost_voltage(StatorVector(*current), 13.0, 1e-6, 1e-4, 0.67, 1.0)
    made = COMMAND._replace(voltage_alpha=3.0 - lost.alpha, voltage_beta=-1.0 - lost.beta)
    np.testing.assert_allclose(found[:7], StatorFrameMotor.transition(StatorFrameMotor.State(*state[:7]), made, FED))
    assert found[7:] == state[7:]
