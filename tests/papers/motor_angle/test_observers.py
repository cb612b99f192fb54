"""The paper's motor and observers against closed forms."""

import numpy as np
import pytest

from papers.motor_angle.steady_motor import load_torque, steady
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters, StatorFrameMotor
from tierod.physics.motor import RotorVector, direction, inverse_park
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.observers import (
    DqMotor,
    FeedforwardAngle,
    LinearSpeed,
    extended_kalman,
    full_observer,
    luenberger,
    q_axis_motor,
    reduced_luenberger,
    reduced_observer,
)

P = load("motor-bench").parameters_for(MotorParameters)
FIXED = load("motor-bench").parameters_for(SampledMotorParameters)
TIME = 1e-4
MOTOR, LOADED = q_axis_motor(P), q_axis_motor(P, load=True)
EMF, TORQUE = 0.034, 0.051  # z_p psi, and 3/2 of it


def test_both_frames_show_the_same_motor():
    step, angle, speed, torque = 1e-7, 0.3, 70.0, 0.4
    current, voltage = RotorVector(3.0, 14.0), RotorVector(-0.5, 4.0)
    rotor = direction(P.motor_pole_pairs * angle)
    fixed = SampledMotorParameters(*[getattr(FIXED, name) for name in list(FIXED.__dataclass_fields__)[:6]], step)
    state = StatorFrameMotor.State(*inverse_park(current, rotor), speed, angle, torque, 0.0, 0.0)
    given = StatorFrameMotor.Input(*inverse_park(voltage, rotor), 0.0, 0.0)
    after = StatorFrameMotor.transition(state, given, fixed)
    turned = direction(P.motor_pole_pairs * after.angle)
    d = after.current_alpha * turned.cosine + after.current_beta * turned.sine
    q = after.current_beta * turned.cosine - after.current_alpha * turned.sine
    rates = DqMotor.derivative(DqMotor.State(*current, speed), DqMotor.Input(*voltage, torque), P)
    expected = [(d - current.d) / step, (q - current.q) / step, (after.speed - speed) / step]
    assert rates == pytest.approx(expected, rel=1e-3)


def test_a_salient_motor_keeps_its_power():
    """What the voltages give is heat, stored energy and mechanical power: with 3/2 and with the reluctance torque."""
    p = MotorParameters(0.05, 1e-4, 0.0085, 4.0, 1.2e-4, 4e-4, motor_saliency=1.7)
    x, u = DqMotor.State(-6.0, 20.0, 90.0), DqMotor.Input(-2.0, 5.0, 0.2)
    rates = DqMotor.derivative(x, u, p)
    given = 1.5 * (u.voltage_d * x.current_d + u.voltage_q * x.current_q)
    heat = 1.5 * p.motor_resistance * (x.current_d**2 + x.current_q**2)
    stored = 1.5 * 1e-4 * (x.current_d * rates.current_d + 1.7 * x.current_q * rates.current_q)
    torque = p.motor_inertia * rates.speed + p.motor_damping * x.speed + u.load_torque
    assert given == pytest.approx(heat + stored + torque * x.speed, rel=1e-12)


def test_the_reduced_observer_is_eq_32_corrected():
    pole = -300.0
    gain = (pole + P.motor_damping / P.motor_inertia) * P.motor_inductance / EMF
    found = reduced_observer(MOTOR, (pole,))
    current = pole * gain + TORQUE / P.motor_inertia + gain * P.motor_resistance / P.motor_inductance
    np.testing.assert_allclose(found.B[0], [-gain / P.motor_inductance, current], rtol=1e-12)
    np.testing.assert_allclose([found.A[0, 0], *found.D[0]], [pole, 0.0, gain], rtol=1e-12)


@pytest.mark.parametrize("make", [luenberger, reduced_luenberger, extended_kalman])
def test_at_a_steady_speed_speed_and_load_are_right(make):
    samples = steady(60.0, 12.0)
    found = scan(make(P, TIME), samples)
    assert found["motor_speed"][-1] == pytest.approx(60.0, rel=0.01)
    assert found["motor_load_torque"][-1] == pytest.approx(load_torque(60.0, 12.0), rel=0.02)


def test_the_angle_begins_at_the_sensor_and_missing_voltages_hold_the_speed():
    samples = steady(50.0, 3.0, angle=2.0)
    samples[:30, 4] = samples[2000:2100, 2] = np.nan
    samples[3000:, 4] += 0.05
    found = scan(luenberger(P, TIME), samples)
    assert found["motor_angle"][30] == pytest.approx(samples[30, 4])
    assert (found["angle_residual_electrical"][:30] == 0.0).all()
    step = found["angle_residual_electrical"][3000] - found["angle_residual_electrical"][2999]
    assert step == pytest.approx(4.0 * 0.05, abs=1e-3)
    assert (found["motor_speed"][2000:2100] == found["motor_speed"][1999]).all()


@pytest.mark.parametrize("speed", [-150.0, 20.0])
@pytest.mark.parametrize("current", [(0.0, 12.0), (-8.0, -15.0)])
def test_the_feedforward_compensates_for_the_lag_of_its_filter(speed, current):
    samples = steady(speed, current[1], current_d=current[0])
    samples[3000:3200, 0] = np.nan  # it turns on while samples are missing
    found = scan(FeedforwardAngle(FIXED), samples)
    assert found["motor_angle"][-1] == pytest.approx(samples[-1, 4], abs=2e-3)
    assert found["motor_speed"][-1] == pytest.approx(speed, rel=2e-3)
    np.testing.assert_allclose(found["motor_angle"][3000:3200], samples[3000:3200, 4], atol=5e-3)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: extended_kalman(P, 1e-3), r"0\.2 at most"),
        (lambda: FeedforwardAngle(FIXED, least_speed=0.0), "least_speed' is 0"),
        (lambda: LinearSpeed.of(full_observer(MOTOR, (100.0, -700.0)), TIME), r"diverges with \+100 1/s"),
    ],
)
def test_impossible_numbers_are_refused(make, says):
    with pytest.raises(ParameterError, match=says):
        make()
