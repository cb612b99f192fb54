from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tierod.core.graph import jacobian
from tierod.models.single_track import SingleTrack
from tierod.physics.aligning import aligning_torque_from_steer, aligning_torque_from_yaw
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient

CAR = SingleTrack.Parameters(
    mass=1600.0,
    yaw_inertia=2800.0,
    front_distance=1.14,
    rear_distance=1.69,
    front_cornering_stiffness=110e3,
    rear_cornering_stiffness=130e3,
)
TRAIL = 0.05


@pytest.mark.parametrize("speed", [5.0, 15.0, 35.0])
def test_three_roads_to_the_steady_yaw_rate_meet(speed):
    steer = SingleTrack.Input(0.01, speed)
    gradient = understeer_gradient(1600.0, 1.14, 1.69, 110e3, 130e3)
    closed = 0.01 * steady_yaw_gain(speed, 2.83, gradient)
    rest = SingleTrack.State(0.0, 0.0)
    system = np.array(jacobian(lambda x: SingleTrack.derivative(x, steer, CAR), rest))
    drive = np.array(SingleTrack.derivative(rest, steer, CAR))
    state_space = np.linalg.solve(system, -drive)[1]
    simulated = solve_ivp(
        lambda _, x: SingleTrack.derivative(SingleTrack.State(*x), steer, CAR),
        (0.0, 20.0),
        [0.0, 0.0],
        rtol=1e-9,
        atol=1e-12,
    ).y[1, -1]
    assert state_space == pytest.approx(closed, rel=1e-12)
    assert simulated == pytest.approx(closed, rel=1e-5)


@given(st.floats(-0.05, 0.05), st.floats(-0.4, 0.4), st.floats(-0.05, 0.05), st.floats(3.0, 50.0))
def test_equations_1_and_4_give_the_torque_of_the_front_axle(sideslip, yaw_rate, steer, speed):
    state, inputs = SingleTrack.State(sideslip, yaw_rate), SingleTrack.Input(steer, speed)
    true = TRAIL * SingleTrack.axle_forces(state, inputs, CAR)[0]
    yaw_acceleration = SingleTrack.derivative(state, inputs, CAR).yaw_rate
    acceleration = SingleTrack.output(state, inputs, CAR).lateral_acceleration
    from_steer = aligning_torque_from_steer(
        15.5 * steer,
        acceleration,
        yaw_rate,
        speed,
        mass=CAR.mass,
        wheelbase=2.83,
        front_stiffness=CAR.front_cornering_stiffness,
        rear_stiffness=CAR.rear_cornering_stiffness,
        trail=TRAIL,
        steering_ratio=1.0 / 15.5,
    )
    from_yaw = aligning_torque_from_yaw(
        acceleration,
        yaw_acceleration,
        mass=CAR.mass,
        yaw_inertia=CAR.yaw_inertia,
        front_distance=CAR.front_distance,
        rear_distance=CAR.rear_distance,
        trail=TRAIL,
    )
    assert from_steer == pytest.approx(true, rel=1e-9, abs=1e-9)
    assert from_yaw == pytest.approx(true, rel=1e-9, abs=1e-9)


def test_a_left_turn_is_positive_throughout():
    turned = SingleTrack.derivative(SingleTrack.State(0.0, 0.0), SingleTrack.Input(0.02, 20.0), CAR)
    seen = SingleTrack.output(SingleTrack.State(0.0, 0.0), SingleTrack.Input(0.02, 20.0), CAR)
    assert turned.yaw_rate > 0.0
    assert seen.lateral_acceleration > 0.0
