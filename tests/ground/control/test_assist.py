from dataclasses import replace

import casadi
import numpy as np
import pytest

from ground.steering.rig import STEP, Rig
from tierod.core.block import leaves, rebuild, tuning, values_of
from tierod.core.graph.derivatives import jacobian
from tierod.physics.assist import assist_torque
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.control.assist import ActiveReturn, AssistMemory, AssistUnit, Characteristic
from tierod_lab.ground.steering.active_front import ActiveFront
from tierod_lab.ground.steering.column_eps import ColumnEps, WormGear
from tierod_lab.ground.steering.friction import Coulomb, DryFriction
from tierod_lab.ground.steering.rack_eps import RackEps
from tierod_lab.ground.steering.shaft import Wheel

SMOOTH = DryFriction(level=0.0)
PLAIN = AssistUnit(active_return=ActiveReturn(gain=0.0), damping=0.0)


def held(unit, torque, speed=0.0, steps=200, angle=0.0, rate=0.0):
    """Requests under a constant driver's torque."""
    memory, requests = unit.remembered(), []
    for _ in range(steps):
        memory, request = unit.decide(memory, torque, speed, angle, rate)
        requests.append(request)
    return np.array(requests)


@pytest.mark.parametrize("speed", [0.0, 12.0, 40.0])
@pytest.mark.parametrize("torque", [-6.0, 0.8, 3.0, 12.0])
def test_settled_request_is_the_map_at_the_motor(torque, speed):
    chart = dict(tuning(PLAIN.characteristic))
    expected = assist_torque(torque, speed, **chart, maximum_torque=60.0) / 20.0
    assert held(PLAIN, torque, speed)[-1] == pytest.approx(expected)


def test_request_keeps_its_limit_and_its_rate():
    requests = held(replace(PLAIN, maximum_torque=40.0, torque_rate=1000.0), 20.0)
    assert np.max(requests) == pytest.approx(2.0)
    assert np.max(np.diff(requests, prepend=0.0)) == pytest.approx(1000.0 * 1e-3 / 20.0)
    assert requests[38] < 2.0


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


@pytest.mark.parametrize("kingpin", [200.0, 5000.0, 100e3])
def test_loop_below_a_superposition_that_stands_still_is_stable_without_hands(kingpin):
    require_stability(Rig(replace(ActiveFront().column, friction=SMOOTH), ActiveFrontCar().assist, kingpin))


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


@pytest.mark.parametrize("name", STEERINGS)
@pytest.mark.parametrize("speed", [0.0, 6.0, 30.0])
def test_released_from_full_lock_of_assist_it_comes_to_rest(name, speed):
    """The nonlinear loop with limits, hands off, after the wheel was pulled with 8 N*m."""
    rig = Rig(replace(STEERINGS[name], friction=DryFriction(1.0)), AssistUnit(), kingpin_stiffness=2000.0)
    _, out = rig.run(14.0, hand_torque=lambda t: np.where(t < 2.0, 8.0, 0.0), speed=speed)
    assert np.max(np.abs(out["steering_wheel_rate"][-1000:])) < 0.02
    assert np.max(np.abs(out["driver_torque"][-1000:])) < 0.1


def rest(unit, speed, friction, kingpin=400.0):
    """Where a wheel comes to rest that was let go at 2 rad."""
    rig = Rig(ColumnEps(friction=DryFriction(friction, Coulomb())), unit, kingpin)
    _, out = rig.run(12.0, rig.placed(angle=2.0, wheel=Wheel(2.0, 0.0)), speed=speed)
    assert abs(out["steering_wheel_rate"][-1]) < 1e-2
    return out["steering_wheel_angle"][-1]


def test_free_steering_returns_until_friction_holds_it():
    kingpin = 400.0
    spring = 2.0 * kingpin / 15.5**2
    assert abs(rest(PLAIN, 6.0, 0.0)) < 0.005
    for friction in (1.0, 3.0):
        left = rest(PLAIN, 6.0, friction)
        assert abs(left) * spring <= friction * 1.01
    assert rest(PLAIN, 6.0, 3.0) > 0.5


def test_active_return_brings_the_wheel_further_back_when_rolling():
    """Where return, as a second spring, and kingpins together are held by friction: 1 N*m*s/rad times 1.5 1/s."""
    spring, friction = 2.0 * 400.0 / 15.5**2, 3.0
    assert rest(AssistUnit(damping=0.0), 6.0, friction) == pytest.approx(friction / (spring + 1.5), rel=0.01)
    assert rest(AssistUnit(), 0.0, friction) == pytest.approx(rest(PLAIN, 0.0, friction), rel=0.02)


def test_damping_opposes_the_rate_at_speed_only():
    unit = AssistUnit(active_return=ActiveReturn(gain=0.0), damping=0.4, damping_speed=15.0)
    assert held(unit, 0.0, 0.0, rate=2.0)[-1] == 0.0
    assert held(unit, 0.0, 15.0, rate=2.0)[-1] == pytest.approx(-0.4 * 0.5 * 2.0 / 20.0)
