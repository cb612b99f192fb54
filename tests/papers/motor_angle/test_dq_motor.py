"""The motor in the rotor's axes against the one in the stator's axes, and against its closed form at rest."""

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.models.linear import linearise
from tierod.models.stator_frame_motor import SampledMotorParameters, StatorFrameMotor
from tierod.physics.clarke_park import RotorVector, direction, inverse_park
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotor, DqMotorParameters, LoadedDqMotor, q_axis_motor, with_load

P = load("motor-bench").parameters_for(DqMotorParameters)


def test_both_axes_show_the_same_motor():
    step, angle, speed, load_torque = 1e-7, 0.3, 70.0, 0.4
    current, voltage = RotorVector(3.0, 14.0), RotorVector(-0.5, 4.0)
    rotor = direction(P.motor_pole_pairs * angle)
    fixed = load("motor-bench").parameters_for(SampledMotorParameters)
    fixed = SampledMotorParameters(*[getattr(fixed, name) for name in list(fixed.__dataclass_fields__)[:6]], step)
    state = StatorFrameMotor.State(*inverse_park(current, rotor), speed, angle, load_torque, 0.0, 0.0)
    given = StatorFrameMotor.Input(*inverse_park(voltage, rotor), 0.0, 0.0)
    after = StatorFrameMotor.transition(state, given, fixed)
    turned = direction(P.motor_pole_pairs * after.angle)
    d = after.current_alpha * turned.cosine + after.current_beta * turned.sine
    q = after.current_beta * turned.cosine - after.current_alpha * turned.sine
    rates = DqMotor.derivative(DqMotor.State(*current, speed), DqMotor.Input(*voltage, load_torque), P)
    assert (d - current.d) / step == pytest.approx(rates.current_d, rel=1e-3)
    assert (q - current.q) / step == pytest.approx(rates.current_q, rel=1e-3)
    assert (after.speed - speed) / step == pytest.approx(rates.speed, rel=1e-4)


def test_a_salient_motor_keeps_its_power():
    """What the voltages give is heat, stored energy and mechanical power: with 3/2 and with the reluctance torque."""
    p = DqMotorParameters(0.05, 1e-4, 0.0085, 4.0, 1.2e-4, 4e-4, motor_saliency=1.7)
    x, u = DqMotor.State(-6.0, 20.0, 90.0), DqMotor.Input(-2.0, 5.0, 0.2)
    rates = DqMotor.derivative(x, u, p)
    given = 1.5 * (u.voltage_d * x.current_d + u.voltage_q * x.current_q)
    heat = 1.5 * p.motor_resistance * (x.current_d**2 + x.current_q**2)
    stored = 1.5 * 1e-4 * (x.current_d * rates.current_d + 1.7 * x.current_q * rates.current_q)
    torque = p.motor_inertia * rates.speed + p.motor_damping * x.speed + u.load_torque
    assert given == pytest.approx(heat + stored + torque * x.speed, rel=1e-12)


def test_the_load_is_the_same_as_a_state():
    x, u = LoadedDqMotor.State(2.0, 9.0, 40.0, 0.3), LoadedDqMotor.Input(0.5, 3.0)
    rates = LoadedDqMotor.derivative(x, u, P)
    assert rates[:3] == DqMotor.derivative(DqMotor.State(*x[:3]), DqMotor.Input(*u, 0.3), P)
    assert rates.load_torque == 0.0


def test_the_linear_motor_is_this_one_without_current_along_the_flux():
    whole = linearise(LoadedDqMotor, P, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0))
    small = with_load(q_axis_motor(P), P.motor_inertia)
    np.testing.assert_allclose(small.A, whole.A[1:, 1:], rtol=1e-12)
    np.testing.assert_allclose(small.B[:, 0], whole.B[1:, 1], rtol=1e-12)
    assert small.states == whole.states[1:]


def test_the_printed_torque_constant_is_two_thirds():
    printed, right = q_axis_motor(P, "printed"), q_axis_motor(P)
    assert printed.A[1, 0] / right.A[1, 0] == pytest.approx(2.0 / 3.0)
    assert right.A[1, 0] * P.motor_inertia == pytest.approx(0.051)
    with pytest.raises(ParameterError, match="expected corrected or printed"):
        q_axis_motor(P, "print")
