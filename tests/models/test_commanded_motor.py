"""A commanded motor is a motor fed with what the inverter leaves of the command."""

import math

import numpy as np
import pytest

from tierod.models.commanded_motor import CommandedMotor, CommandedMotorParameters
from tierod.models.stator_frame_motor import SampledMotorParameters, StatorFrameMotor
from tierod.physics.clarke_park import StatorVector
from tierod.physics.inverter import lost_voltage

VALUES = (0.05, 1e-4, 0.01, 4.0, 1e-4, 1e-4)
INVERTER = CommandedMotorParameters(*VALUES, inverter_voltage_loss=0.8, inverter_knee_current=2.0)
MOTOR = SampledMotorParameters(*VALUES)
COMMAND = StatorFrameMotor.Input(3.0, -1.0, 0.0, 0.0)


@pytest.mark.parametrize("current", [(8.0, 3.0), (0.4, -0.3), (-1.5, 6.0)])
def test_it_is_a_motor_with_the_loss_taken_from_the_command(current):
    state = CommandedMotor.State(*current, 40.0, 0.3, 0.1, 0.1, -0.02, 0.8, math.log(0.5))
    found = CommandedMotor.transition(state, COMMAND, INVERTER)
    lost = lost_voltage(StatorVector(*current), 13.0, 1e-6, 1e-4, 0.67, 1.0)
    made = COMMAND._replace(voltage_alpha=3.0 - lost.alpha, voltage_beta=-1.0 - lost.beta)
    np.testing.assert_allclose(found[:7], StatorFrameMotor.transition(StatorFrameMotor.State(*state[:7]), made, MOTOR))
    assert found[7:] == state[7:]


def test_an_inverter_without_loss_makes_its_command():
    state = CommandedMotor.State(8.0, 3.0, 40.0, 0.3, 0.1, 0.0, 0.0, 0.0, 0.0)
    found = CommandedMotor.transition(state, COMMAND, INVERTER)
    np.testing.assert_allclose(
        found[:7], StatorFrameMotor.transition(StatorFrameMotor.State(*state[:7]), COMMAND, MOTOR)
    )
