"""Column and rack steering against their differential equations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ground.rigs import STEP, Rig
from tierod.core.graph.trace import jacobian
from tierod.physics.friction import dahl_slope
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering import Linkage, Motor, Ripple
from tierod_lab.ground.steering.column_eps import ColumnEps, Rotor, WormGear
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DryFriction, LuGre
from tierod_lab.ground.steering.rack_eps import demonstrator_rack

SMOOTH = DryFriction(level=0.0)
PARALLEL = Linkage(ackermann_gain=0.0)


def below(steering):
    motor = steering.motor
    return steering.column_inertia + steering.linkage.inertia + motor.ratio**2 * motor.inertia


def viscosity(steering):
    wheel = steering.wheel_damping if steering.torsion_bar is None else 0.0
    return wheel + steering.damping + steering.motor.ratio**2 * steering.motor.damping


def test_steering_with_friction_is_its_differential_equation():
    """The published equations of column, bar and Dahl friction, integrated in time by an adaptive method."""
    friction, spring = DryFriction(4.0, Dahl(math.radians(0.5))), 30.0
    steering = ColumnEps(friction=friction, linkage=PARALLEL)
    rig = Rig(steering, kingpin_stiffness=0.5 * spring / steering.linkage.ratio**2)
    hand = lambda t: 9.0 * np.sin(6.0 * t)  # noqa: E731
    bar = steering.torsion_bar

    def derivative(t, x):
        wheel, wheel_rate, column, rate, share = x
        torque = bar.stiffness * (wheel - column) + bar.damping * (wheel_rate - rate)
        drive = torque - friction.level * share - spring * column - viscosity(steering) * rate
        bend = rate * dahl_slope(share, math.copysign(1.0, rate), friction.law.angle)
        held = hand(t) - steering.wheel_damping * wheel_rate
        return [wheel_rate, (held - torque) / steering.wheel_inertia, rate, drive / below(steering), bend]

    time, out = rig.run(3.0, hand_torque=lambda t: hand(t + 0.5 * STEP))
    solved = solve_ivp(derivative, (0.0, 3.0), [0.0] * 5, t_eval=time, rtol=1e-8, atol=1e-9, max_step=2e-3)
    wheel, wheel_rate, column, _, share = solved.y
    for ours, theirs in (
        (out["steering_wheel_angle"], wheel),
        (out["steering_wheel_rate"], wheel_rate),
        (out["pinion_angle"], column),
        (out["truth_friction_resistance"], friction.level * share),
    ):
        assert np.sqrt(np.mean((ours - theirs) ** 2)) < 0.005 * np.std(theirs)


@pytest.mark.parametrize(
    "steering",
    [
        ColumnEps(linkage=Linkage(ratio_growth=0.004, friction=DryFriction(15.0))),
        ColumnEps(torsion_bar=None, motor=Motor(ripple=Ripple())),
        ColumnEps(friction=DryFriction(8.0, LuGre(), bump=3.0, bump_angle=0.5, left_excess=1.0)),
    ],
    ids=["kingpin friction", "rigid, ripple", "bump"],
)
def test_work_of_hands_and_motor_is_energy_stored_and_lost(steering):
    rig = Rig(steering, kingpin_stiffness=3000.0)
    motor = steering.motor
    time, out = rig.run(8.0, hand_torque=lambda t: 9.0 * np.sin(2.0 * t), motor_torque=lambda t: 0.7 * np.sin(3.1 * t))
    rate = out["motor_speed"] / motor.ratio
    shaft = motor.shaft_torque(out["motor_torque"], out["motor_angle_mechanical"])
    power = out["driver_torque"] * rate + shaft * out["motor_speed"]
    power -= out["truth_friction_resistance"] * rate + viscosity(steering) * rate**2
    left, right = out["road_wheel_angle_left"], out["road_wheel_angle_right"]
    stored = 1500.0 * (left**2 + right**2)
    inertia = below(steering) + (steering.wheel_inertia if steering.torsion_bar is None else 0.0)
    stored += 0.5 * inertia * rate**2
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    moved = np.sum(np.abs(power)) * STEP
    assert np.max(np.abs(work - stored)) < 0.003 * moved
    assert np.ptp(out["pinion_angle"]) > 0.5


@pytest.mark.parametrize("play", [0.0, 0.005, 0.02])
def test_motor_turns_freely_within_the_play_of_the_worm(play):
    gear = WormGear(play=play)
    steering = ColumnEps(friction=SMOOTH, worm_gear=gear)
    rig = Rig(steering, kingpin_stiffness=1e6)
    _, out = rig.run(8.0, motor_torque=lambda t: np.where(t < 4.0, 0.02, -0.02))
    twist = out["motor_angle_mechanical"] / steering.motor.ratio - out["pinion_angle"]
    swing = twist[3999] - twist[7999]
    assert swing == pytest.approx(play + 2.0 * 0.4 / gear.stiffness, abs=2e-6)
    assert rig.steering.stiff().rotor == Rotor(20.0 * play, 0.0)


def test_friction_holds_without_creeping():
    steering = ColumnEps(friction=DryFriction(4.0, Coulomb()))
    rig = Rig(steering)
    _, out = rig.run(10.0, hand_torque=lambda t: np.where(t < 0.5, 0.0, 3.0 + 0.5 * np.sin(7.0 * t)))
    angle = out["pinion_angle"]
    assert np.max(np.abs(angle[2000:] - np.mean(angle[2000:]))) < steering.friction.law.angle
    assert abs(np.mean(angle[-2000:]) - np.mean(angle[2000:4000])) < 0.01 * steering.friction.law.angle


def matrix(steering):
    at, memory = steering.stiff(), steering.remembered()
    idle = Loads(0.0, 0.0, 0.0, (0.0,) * len(steering.actuators), 0.0, 0.0)
    return np.array(jacobian(lambda motion: steering.derivative(motion, at, memory, idle), at))


def test_demonstrator_has_the_modes_of_its_printed_parameters():
    """Closed form with the rates of Table A1: a stiff pair of 667 Hz (undamped 918 Hz) and two slow real ones."""
    steering = demonstrator_rack()
    poles = np.sort_complex(np.linalg.eigvals(matrix(steering)))
    inertia, mass, ratio = 0.045, 3.0, 1.0 / 146.12
    system = [
        [0, 1, 0, 0],
        [-1e8 * ratio**2 / inertia, -1e3 * ratio**2 / inertia, 1e8 * ratio / inertia, 1e3 * ratio / inertia],
        [0, 0, 0, 1],
        [1e8 * ratio / mass, 1e3 * ratio / mass, -(1e8 + 31227.0) / mass, -(1e3 + 22867.0) / mass],
    ]
    np.testing.assert_allclose(poles, np.sort_complex(np.linalg.eigvals(np.array(system))), rtol=1e-6)
    assert np.max(np.abs(poles.imag)) / (2.0 * math.pi) == pytest.approx(667.0, abs=1.0)
    assert sorted(poles.real)[-2:] == pytest.approx([-22.4, -1.45], abs=0.02)
