import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ground.steering.rig import STEP, Rig
from tierod.core.block import leaves
from tierod.physics.friction import dahl_slope
from tierod_lab.ground.steering.column_eps import ColumnEps, Rotor, WormGear
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DahlPower, DryFriction, LuGre, MaxwellSlip, Stribeck
from tierod_lab.ground.steering.linkage import Linkage
from tierod_lab.ground.steering.shaft import Motor, Ripple, TorsionBar, Wheel

SMOOTH = DryFriction(level=0.0)
PARALLEL = Linkage(ackermann_gain=0.0)
RIGID = ColumnEps(friction=SMOOTH, linkage=PARALLEL, torsion_bar=None)


def below(steering):
    motor = steering.motor
    return steering.column_inertia + steering.linkage.inertia + motor.ratio**2 * motor.inertia


def viscosity(steering):
    wheel = steering.wheel_damping if steering.torsion_bar is None else 0.0
    return wheel + steering.damping + steering.motor.ratio**2 * steering.motor.damping


@pytest.mark.parametrize("kingpin", [2000.0, 8000.0])
def test_free_swing_has_the_natural_frequency_and_damping_of_the_column(kingpin):
    rig = Rig(RIGID, kingpin_stiffness=kingpin)
    time, out = rig.run(1.0, rig.placed(angle=0.2))
    inertia = below(RIGID) + RIGID.wheel_inertia
    frequency = math.sqrt(2.0 * kingpin * RIGID.linkage.ratio**2 / inertia)
    damping = viscosity(RIGID) / (2.0 * inertia * frequency)
    swing = frequency * math.sqrt(1.0 - damping**2)
    expected = np.cos(swing * time) + damping * frequency / swing * np.sin(swing * time)
    expected *= 0.2 * np.exp(-damping * frequency * time)
    np.testing.assert_allclose(out["steering_wheel_angle"], expected, atol=0.2 * 2e-3)


def test_wheel_bar_and_column_swing_as_the_linear_system():
    steering = ColumnEps(friction=SMOOTH, linkage=PARALLEL)
    rig = Rig(steering, kingpin_stiffness=4000.0)
    _, out = rig.run(1.0, rig.placed(wheel=Wheel(0.1, 0.0)))
    bar, top, low = steering.torsion_bar, steering.wheel_inertia, below(steering)
    spring = 8000.0 * steering.linkage.ratio**2
    system = np.array(
        [
            [0, 1, 0, 0],
            [
                -bar.stiffness / top,
                -(bar.damping + steering.wheel_damping) / top,
                bar.stiffness / top,
                bar.damping / top,
            ],
            [0, 0, 0, 1],
            [
                bar.stiffness / low,
                bar.damping / low,
                -(bar.stiffness + spring) / low,
                -(bar.damping + viscosity(steering)) / low,
            ],
        ]
    )
    for instant in (0.05, 0.3, 0.9):
        wheel, wheel_rate, column, column_rate = expm(system * instant) @ [0.1, 0.0, 0.0, 0.0]
        row = out.at(round(instant / STEP))
        assert row.steering_wheel_angle == pytest.approx(wheel, abs=3e-4)
        assert row.steering_wheel_rate == pytest.approx(wheel_rate, abs=2e-2)
        assert row.pinion_angle == pytest.approx(column, abs=3e-4)
        assert row.motor_speed == pytest.approx(steering.motor.ratio * column_rate, abs=0.3)


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


LAWS = [Coulomb(), Dahl(), DahlPower(exponent=0.5), DahlPower(exponent=2.0), MaxwellSlip(), Stribeck(), LuGre()]


@pytest.mark.parametrize("turns", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("law", LAWS, ids=[f"{type(law).__name__}{getattr(law, 'exponent', '')}" for law in LAWS])
def test_loop_of_the_hands_is_the_work_of_friction(law, turns):
    steering = ColumnEps(
        friction=DryFriction(4.0, law), damping=0.0, motor=Motor(damping=0.0), torsion_bar=TorsionBar(damping=0.0)
    )
    rig = Rig(steering, kingpin_stiffness=3000.0, arm_stiffness=300.0, arm_damping=3.0)
    period = 2.0 * math.pi / turns
    time, out = rig.run(4.0 * period, hand_angle=lambda t: 0.6 * np.sin(turns * t))
    last = time > 2.0 * period
    hands = np.trapezoid(out["driver_torque"][last], out["steering_wheel_angle"][last])
    friction = np.trapezoid(out["truth_friction_resistance"][last], out["pinion_angle"][last])
    assert hands == pytest.approx(friction, rel=0.01)
    assert 0.0 < friction < 1.25 * 4.0 * np.sum(np.abs(np.diff(out["pinion_angle"][last])))


def test_loop_of_coulombs_law_is_level_times_path():
    steering = ColumnEps(friction=DryFriction(4.0, Coulomb()))
    rig = Rig(steering, arm_stiffness=300.0, arm_damping=3.0)
    time, out = rig.run(4.0 * math.pi, hand_angle=lambda t: 0.6 * np.sin(t))
    last = time > 2.0 * math.pi
    pinion = out["pinion_angle"][last]
    loop = np.trapezoid(out["truth_friction_resistance"][last], pinion)
    swing = 0.5 * (pinion.max() - pinion.min())
    elastic = steering.friction.law.angle
    assert loop == pytest.approx(4.0 * 4.0 * (swing - elastic), rel=0.01)


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


def test_torques_in_balance_at_rest():
    rig = Rig(ColumnEps(friction=SMOOTH), kingpin_stiffness=3000.0)
    _, out = rig.run(8.0, hand_torque=3.0, motor_torque=0.2)
    row = out.at(-1)
    linkage = rig.steering.linkage
    assert row.driver_torque == pytest.approx(3.0)
    assert row.steering_wheel_angle - row.pinion_angle == pytest.approx(3.0 / 140.0)
    assert row.rack_force * linkage.rack_ratio == pytest.approx(3.0 + 20.0 * 0.2)
    assert row.tie_rod_force_left + row.tie_rod_force_right == pytest.approx(row.rack_force)
    assert row.rack_position == pytest.approx(linkage.rack_ratio * row.pinion_angle)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_end_stop_holds_hands_and_motor(side):
    rig = Rig(ColumnEps())
    _, out = rig.run(6.0, hand_torque=8.0 * side, motor_torque=3.0 * side)
    stop = rig.steering.linkage.end_stop
    row = out.at(-1)
    assert abs(row.steering_wheel_rate) < 1e-3
    pushed = (8.0 + 60.0 - abs(row.truth_friction_resistance)) / stop.stiffness
    assert side * row.pinion_angle - stop.angle == pytest.approx(pushed, rel=1e-3)
    assert np.max(side * out["pinion_angle"]) < stop.angle + 1.0


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


@pytest.mark.parametrize(
    "steering",
    [
        ColumnEps(friction=DryFriction(12.5, Dahl(math.radians(0.3)))),
        ColumnEps(friction=DryFriction(12.5, Coulomb()), worm_gear=WormGear()),
        ColumnEps(friction=DryFriction(4.0, LuGre()), worm_gear=WormGear(play=0.004)),
    ],
    ids=["dahl", "coulomb, worm", "lugre, lash"],
)
def test_a_millisecond_is_short_enough(steering):
    result = {"hand_angle": lambda t: 0.6 * np.sin(1.5 * t), "motor_torque": lambda t: 0.4 * np.sin(1.5 * t)}
    rig = Rig(steering, kingpin_stiffness=3000.0, arm_stiffness=60.0, arm_damping=2.0)
    _, coarse = rig.run(5.0, **result)
    _, fine = replace(rig, step_time=STEP / 20.0).run(5.0, **result)
    for name in ("steering_wheel_angle", "driver_torque", "rack_force", "pinion_angle"):
        error = coarse[name] - fine[name][::20]
        assert np.sqrt(np.mean(error**2)) < 0.01 * np.std(fine[name]), name


def test_float_steps_agree_with_the_kernel():
    rig = Rig(ColumnEps(worm_gear=WormGear(play=0.002)), kingpin_stiffness=3000.0)
    _, out = rig.run(0.05, hand_torque=lambda t: 6.0 * np.cos(30.0 * t), motor_torque=0.1)
    state = rig.init()
    for k, row in enumerate(out.values):
        sample = rig.Sample(6.0 * math.cos(30.0 * k * STEP), motor_torque=0.1)
        state, signals = rig.step(state, sample)
        np.testing.assert_allclose([leaf for _, leaf in leaves(signals)], row, rtol=1e-9, atol=1e-12)
