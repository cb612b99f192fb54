import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from ground.steering.rig import STEP, Rig
from tierod.core.graph.derivatives import jacobian
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.demonstrator import demonstrator_rack
from tierod_lab.ground.steering.friction import Coulomb, DryFriction, LuGre
from tierod_lab.ground.steering.linkage import Linkage
from tierod_lab.ground.steering.rack_eps import Mesh, RackEps

SMOOTH = DryFriction(level=0.0)


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


def test_a_millisecond_follows_the_demonstrator_as_the_matrix_exponential_does():
    steering = replace(demonstrator_rack(), friction=SMOOTH)
    rig = Rig(steering)
    _, out = rig.run(2.0, rig.placed(rate=1.0))
    start = np.zeros(4)
    start[1] = 1.0
    for instant in (0.02, 0.3, 1.9):
        angle, rate, position, _ = expm(matrix(steering) * instant) @ start
        row = out.at(round(instant / STEP))
        assert row.steering_wheel_angle == pytest.approx(angle, rel=0.01)
        assert row.rack_position == pytest.approx(position, rel=0.01)
        assert row.steering_wheel_rate == pytest.approx(rate, rel=0.02)


CASES = {
    "typical": RackEps(),
    "motor on the pinion": RackEps(motor_on_rack=False),
    "friction on the pinion": RackEps(friction_on_rack=False),
    "lash": RackEps(mesh=Mesh(play=2e-5), friction=DryFriction(4.0, LuGre())),
    "demonstrator": demonstrator_rack(),
    "demonstrator with lash": replace(demonstrator_rack(), mesh=Mesh(1e8, 1e3, 5e-5)),
}


@pytest.mark.parametrize("name", CASES)
def test_a_millisecond_agrees_with_a_twentieth_of_it(name):
    result = {"hand_angle": lambda t: 0.6 * np.sin(1.5 * t), "motor_torque": lambda t: 0.3 * np.sin(2.0 * t)}
    rig = Rig(CASES[name], kingpin_stiffness=1000.0, arm_stiffness=60.0, arm_damping=2.0)
    _, coarse = rig.run(4.0, **result)
    _, fine = replace(rig, step_time=STEP / 20.0).run(4.0, **result)
    for signal in ("steering_wheel_angle", "driver_torque", "rack_position", "rack_force", "pinion_angle"):
        error = coarse[signal] - fine[signal][::20]
        assert np.sqrt(np.mean(error**2)) < 0.01 * np.std(fine[signal]), signal


@pytest.mark.parametrize("play", [0.0, 1e-4])
def test_hard_knocks_stay_bounded_at_a_millisecond(play):
    rig = Rig(RackEps(mesh=Mesh(play=play)), kingpin_stiffness=1000.0)
    _, out = rig.run(
        20.0, hand_torque=lambda t: 8.0 * np.sign(np.sin(9.0 * t)), motor_torque=lambda t: np.sin(31.0 * t)
    )
    assert np.all(np.isfinite(out.values))
    late, early = (np.max(np.abs(out["steering_wheel_rate"][part])) for part in (slice(-5000, None), slice(5000)))
    assert late < 1.5 * early


@pytest.mark.parametrize("friction_on_rack", [True, False])
def test_stiff_sticking_holds_a_light_pinion(friction_on_rack):
    """A spring of 72 kN*m/rad on 0.0004 kg*m**2 would swing 13 rad per step."""
    stiff = DryFriction(12.5, Coulomb(math.radians(0.01)))
    rig = Rig(RackEps(friction=stiff, friction_on_rack=friction_on_rack), kingpin_stiffness=400.0)
    _, out = rig.run(6.0, hand_torque=lambda t: np.where(t < 2.0, 20.0 * np.sin(3.0 * t), 6.0))
    assert np.ptp(out["pinion_angle"][4000:]) < 1e-5
    assert np.max(np.abs(out["truth_friction_resistance"])) == pytest.approx(12.5)


def test_static_gain_of_the_rack():
    rig = Rig(RackEps(friction=SMOOTH), kingpin_stiffness=3000.0)
    _, out = rig.run(10.0, hand_torque=3.0, motor_torque=0.2)
    row, linkage = out.at(-1), rig.steering.linkage
    assert row.rack_force * linkage.rack_ratio == pytest.approx(3.0 + 20.0 * 0.2)
    mesh = linkage.rack_ratio * row.pinion_angle - row.rack_position
    assert mesh == pytest.approx(3.0 / linkage.rack_ratio / rig.steering.mesh.stiffness, rel=1e-6)


def test_pinion_turns_freely_within_the_play():
    play = 2e-4
    rig = Rig(RackEps(friction=SMOOTH, torsion_bar=None, mesh=Mesh(play=play)), kingpin_stiffness=1e6)
    _, out = rig.run(16.0, hand_torque=lambda t: np.where(t < 8.0, 0.2, -0.2))
    slack = rig.steering.linkage.rack_ratio * out["pinion_angle"] - out["rack_position"]
    compliance = 2.0 * 0.2 / rig.steering.linkage.rack_ratio / rig.steering.mesh.stiffness
    assert slack[7999] - slack[15999] == pytest.approx(play + compliance, rel=1e-3)


@pytest.mark.parametrize("motor_on_rack", [True, False])
@pytest.mark.parametrize("friction_on_rack", [True, False])
def test_slow_turns_are_those_of_a_column(motor_on_rack, friction_on_rack):
    linkage = Linkage(friction=DryFriction(10.0))
    column = ColumnEps(column_inertia=4e-4, damping=0.1, linkage=linkage)
    rack = RackEps(
        rack_mass=1e-3,
        rack_damping=0.0,
        mesh=Mesh(1e9, 1e4),
        motor_on_rack=motor_on_rack,
        friction_on_rack=friction_on_rack,
        linkage=linkage,
    )
    result = {"hand_torque": lambda t: 9.0 * np.sin(2.0 * t), "motor_torque": lambda t: 0.3 * np.sin(2.0 * t)}
    runs = [Rig(steering, kingpin_stiffness=3000.0).run(6.0, **result)[1] for steering in (column, rack)]
    for name in runs[0].names:
        if name != "truth_steering_wheel_acceleration":
            scale = np.max(np.abs(runs[0][name]))
            np.testing.assert_allclose(runs[1][name], runs[0][name], atol=0.01 * scale, err_msg=name)


def test_work_of_hands_and_motor_is_energy_stored_and_lost():
    steering = RackEps(friction=DryFriction(6.0), linkage=Linkage(friction=DryFriction(10.0)))
    rig = Rig(steering, kingpin_stiffness=3000.0)
    time, out = rig.run(8.0, hand_torque=lambda t: 9.0 * np.sin(2.0 * t), motor_torque=lambda t: 0.6 * np.sin(3.1 * t))
    ratio, motor = steering.linkage.rack_ratio, steering.motor
    rate = np.gradient(out["pinion_angle"], time)
    rack_rate = out["rack_speed"] / ratio
    power = out["driver_torque"] * rate + out["motor_torque"] * out["motor_speed"]
    power -= steering.pinion_damping * rate**2 + steering.rack_damping * out["rack_speed"] ** 2
    power -= motor.damping * out["motor_speed"] ** 2 + out["truth_friction_resistance"] * rack_rate
    left, right = out["road_wheel_angle_left"], out["road_wheel_angle_right"]
    moving = steering.rack_mass * ratio**2 + steering.linkage.inertia + motor.ratio**2 * motor.inertia
    stored = 1500.0 * (left**2 + right**2) + 0.5 * moving * rack_rate**2
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    assert np.max(np.abs(work - stored)) < 0.003 * np.sum(np.abs(power)) * STEP


def test_a_rack_may_have_no_motor():
    steering = RackEps(motor=None)
    assert steering.actuators == ()
    _, out = Rig(steering, kingpin_stiffness=2000.0).run(0.5, hand_torque=8.0)
    assert out["steering_wheel_angle"][-1] > 0.0
    assert not np.any(out["motor_torque"])
