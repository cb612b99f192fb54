"""Assist unit, drivers, and the controls of angle and speed."""

import math
from dataclasses import replace

import casadi
import numpy as np
import pytest

from ground.rigs import STEP, Rig
from tierod.core.block import leaves, rebuild, values_of
from tierod.core.graph.trace import jacobian
from tierod_lab.ground.control import ActiveReturn, AngleControl, AssistMemory, AssistUnit, Characteristic
from tierod_lab.ground.drivers import AutomatedDriver, Sensed, Split
from tierod_lab.ground.laws import steady_road_wheel_angle
from tierod_lab.ground.parts import Demand, Hand, Seen
from tierod_lab.ground.steering import Wheel
from tierod_lab.ground.steering.column_eps import ColumnEps, WormGear
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.rack_eps import RackEps

SMOOTH = DryFriction(level=0.0)
PLAIN = AssistUnit(active_return=ActiveReturn(gain=0.0), damping=0.0)


@pytest.mark.parametrize("frequency", [1.0, 10.0, 60.0])
def test_lead_filter_has_its_frequency_response(frequency):
    """(1 + lead s) / (1 + lag s) with Tustin's s = 2 (z - 1) / (T (z + 1))."""
    linear = Characteristic(1.0, 0.0)
    unit = replace(PLAIN, characteristic=linear, lead_time=0.02, lag_time=0.003, motor_ratio=1.0)
    time = np.arange(3000) * STEP
    memory, out = unit.remembered(), []
    for torque in np.sin(2.0 * np.pi * frequency * time).tolist():
        memory, request = unit.decide(memory, torque, 0.0, 0.0, 0.0)
        out.append(request)
    wave = np.exp(-2j * np.pi * frequency * time[1000:])
    gain = 2j * np.mean(np.array(out)[1000:] * wave)
    z = np.exp(2j * np.pi * frequency * STEP)
    s = 2.0 / STEP * (z - 1.0) / (z + 1.0)
    assert gain == pytest.approx((1.0 + 0.02 * s) / (1.0 + 0.003 * s), rel=0.02)


STEERINGS = {
    "column": ColumnEps(friction=SMOOTH),
    "column, worm": ColumnEps(friction=SMOOTH, worm_gear=WormGear()),
    "rack": RackEps(friction=SMOOTH),
    "rack, motor on the pinion": RackEps(friction=SMOOTH, motor_on_rack=False),
}


def poles(rig):
    unit, steering, shape = rig.assist, rig.steering, rig.placed()
    moving = [k for k, (path, _) in enumerate(leaves(shape)) if not path.startswith("friction")]
    symbols, angle, speed = casadi.SX.sym("x", len(values_of(shape))), casadi.SX.sym("angle"), casadi.SX.sym("speed")
    given = rig.Sample(hand_angle=angle, speed=speed)
    rows = jacobian(lambda each: rig.step(each, given)[0], rebuild(shape, casadi.vertsplit(symbols)))
    chosen = casadi.vertcat(*(casadi.horzcat(*(rows[i][j] for j in moving)) for i in moving))
    step = casadi.Function("step", [symbols, angle, speed], [chosen])

    def at(torque, speed):
        assist = unit.characteristic.torque(torque, speed, unit.maximum_torque)
        motor = {"motor_torque": assist / steering.motor.ratio}
        state = rig.placed(wheel=Wheel(torque / steering.torsion_bar.stiffness, 0.0), **motor)
        state = state._replace(assist=AssistMemory(torque, torque, assist))
        return np.linalg.eigvals(np.array(step(values_of(state), state.motion.steering.wheel.angle, speed)))

    return at


@pytest.mark.parametrize(
    "hands", [(0.0, 0.0), pytest.param((5.0, 0.3), marks=pytest.mark.slow), (40.0, 2.0)], ids=["off", "light", "on"]
)
@pytest.mark.parametrize("name", STEERINGS)
@pytest.mark.parametrize("kingpin", [200.0, pytest.param(5000.0, marks=pytest.mark.slow), 100e3])
def test_loop_of_bar_and_motor_is_stable_on_the_whole_map(name, hands, kingpin):
    require_stability(Rig(STEERINGS[name], AssistUnit(), kingpin, 9400.0, *hands))


def require_stability(rig):
    """Gains of the map grow to 19 just below the limit of the motor, at rest; sticking friction is a stiff spring."""
    poles_at = poles(rig)
    for speed in (0.0, 6.0, 60.0):
        for torque in (0.01, 3.0, 5.6):
            worst = np.max(np.abs(poles_at(torque, speed)))
            assert worst < 1.0, (speed, torque, worst)


def test_without_the_lead_the_loop_would_be_unstable():
    rig = Rig(STEERINGS["column"], AssistUnit(lead_time=0.0), 1000.0)
    assert np.max(np.abs(poles(rig)(5.6, 0.0))) > 1.0


CONTROL_STEP = 1e-3
CONTROL = AngleControl(stiffness=40.0, damping=1.5, integral=100.0, torque_limit=10.0)


def follow(control, target, disturbance=0.0, inertia=0.05, damping=0.5):
    """A damped inertia under the control, by semi-implicit steps of 1 ms."""
    memory, angle, rate, angles, torques = control.remembered(), 0.0, 0.0, [], []
    for wanted in target:
        memory, torque = control.decide(memory, float(wanted), angle)
        rate += CONTROL_STEP * (torque + disturbance - damping * rate) / inertia
        angle += CONTROL_STEP * rate
        angles.append(angle)
        torques.append(torque)
    return np.array(angles), np.array(torques)


def test_the_limit_holds_and_nothing_winds_up():
    angles, torques = follow(CONTROL, np.full(4000, 4.0))
    small, _ = follow(CONTROL, np.full(4000, 0.1))
    assert np.max(np.abs(torques)) == CONTROL.torque_limit
    assert np.max(angles) / 4.0 < np.max(small) / 0.1
    assert angles[-1] == pytest.approx(4.0, abs=1e-3)


AUTOMATED = AutomatedDriver(target_rate=1e6)
ON_THE_PATH = Seen(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Hand(0.0, 0.0))
STRAIGHT = Demand(8.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
CRUISING = Sensed(8.0, 0.0, 0.0)


def targets(driver=AUTOMATED, place=ON_THE_PATH, demand=STRAIGHT, sensed=CRUISING):
    return driver.command(driver.reset(), place, demand, sensed)[1]


def test_a_bend_ahead_is_steered_as_the_single_track_needs():
    steer = math.atan(steady_road_wheel_angle(0.05, 8.0, AUTOMATED.wheelbase, AUTOMATED.understeer_gradient))
    bend = targets(demand=STRAIGHT._replace(curvature_ahead=0.05), place=ON_THE_PATH._replace(curvature=0.05),
                   sensed=CRUISING._replace(yaw_rate=0.4))  # fmt: skip
    assert bend.steering_wheel_angle == pytest.approx(19.7 * steer)


def test_motors_share_the_torque_and_wheels_help_if_asked():
    helped = AutomatedDriver(split=Split(0.6, 0.1, 0.24), drive_steering=50.0)
    wanted = targets(helped, sensed=CRUISING._replace(steering_wheel_angle=-0.1))
    total = wanted.steering_torque_1 + wanted.steering_torque_2
    assert total > 0.0
    assert wanted.steering_torque_1 == pytest.approx(0.7 * total)
    assert wanted.drive_difference == pytest.approx(50.0 * total)
