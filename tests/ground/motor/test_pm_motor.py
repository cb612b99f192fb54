import math
from dataclasses import replace

import numpy as np
import pytest

from ground.channels import Run
from ground.motor.motor_bench import MotorBench
from ground.motor.three_phases import ThreePhases
from tierod.core.block import leaves, rebuild, skeleton
from tierod.physics.clarke_park import StatorVector, inverse_clarke
from tierod.physics.inverter import longest_voltage
from tierod_lab.ground.motor import AFS_MOTOR, EPS_MOTOR, Inverter, Rotor, Warming
from tierod_lab.ground.motor.machine import Winding, advance, begin

PERIOD = 1e-4
IDEAL = Inverter(dead_time=0.0, forward_drop=0.0)
TORQUE_CONSTANT = 0.051
COLD = Warming(ambient_temperature=293.15)
"""Resistance and flux are stated at this temperature."""


def smooth(motor=AFS_MOTOR, **changed):
    machine = replace(motor.machine, **{"friction": 0.0, "cogging": 0.0} | changed)
    return replace(motor, machine=machine, inverter=IDEAL, warming=COLD)


@pytest.mark.parametrize("motor", [smooth(), smooth(EPS_MOTOR)])
def test_it_turns_as_three_phases_do(motor):
    """The same voltages fed to an independent machine in phase coordinates, open loop, up to 0.09 rad per period."""
    run = Run(MotorBench(motor), 60, request=1.2, load=0.1)
    voltages = StatorVector(run["motor_voltage_alpha"][1:], run["motor_voltage_beta"][1:])
    phases = np.column_stack(inverse_clarke(voltages))
    states = ThreePhases(motor.machine, load=0.1).run(phases, PERIOD)
    assert np.max(states[:, 3]) > 100.0
    size = np.max(np.abs(states[:, 0]))
    np.testing.assert_allclose(run["motor_current_alpha"][1:], states[:, 0], atol=0.01 * size)
    np.testing.assert_allclose(
        run["motor_current_beta"][1:], (states[:, 1] - states[:, 2]) / 3.0**0.5, atol=0.01 * size
    )
    np.testing.assert_allclose(run["motor_speed"][1:], states[:, 3], rtol=1e-3, atol=0.05)
    np.testing.assert_allclose(run["motor_angle_mechanical"][1:], states[:, 4], atol=2e-3)


def test_requested_torque_arrives_and_stays():
    run = Run(MotorBench(smooth()), 60, request=1.0, locked=1.0)
    torque = run["motor_torque"]
    assert torque[-1] == pytest.approx(1.0, rel=1e-3)
    assert np.max(torque) < 1.05
    quadrature = run["motor_current_beta"] * TORQUE_CONSTANT
    risen = np.argmax(quadrature > 1.0 - math.exp(-1.0)) * PERIOD
    assert AFS_MOTOR.control.lag < risen < AFS_MOTOR.control.lag + 2.5 * PERIOD
    assert not np.any(run["motor_speed"])


def test_steady_torque_is_what_load_and_friction_take():
    run = Run(MotorBench(), 1500, request=0.8, load=0.3, load_damping=0.01)
    speed, machine = np.mean(run["motor_speed"][-5000:]), AFS_MOTOR.machine
    opposing = 0.3 + 0.01 * speed + machine.friction + machine.damping * speed
    assert np.mean(run["motor_torque"][-500:]) == pytest.approx(opposing, rel=1e-3)
    assert np.mean(run["truth_load_torque"][-500:]) == pytest.approx(0.3 + 0.01 * speed, rel=1e-3)
    assert run["truth_motor_friction_torque"][-1] == pytest.approx(machine.friction, rel=1e-6)


@pytest.mark.parametrize("speed", [-60.0, 60.0])
def test_turning_magnets_induce_the_back_emf(speed):
    run = Run(MotorBench(smooth(), carried=True), 400, carried_speed=speed)
    voltage = np.hypot(run["motor_voltage_alpha"], run["motor_voltage_beta"])
    assert np.mean(voltage[-500:]) == pytest.approx(0.034 * abs(speed), rel=2e-3)
    assert np.max(np.abs(run["motor_current_alpha"][-500:])) < 0.1
    turned = np.unwrap(np.arctan2(run["motor_voltage_beta"], run["motor_voltage_alpha"])[-500:])
    assert np.sign(turned[-1] - turned[0]) == np.sign(speed)


def test_a_carried_motor_gives_its_torque():
    run = Run(MotorBench(EPS_MOTOR, carried=True), 300, carried_speed=40.0, request=2.0)
    constant = 1.5 * 4 * EPS_MOTOR.control.flux
    assert np.mean(run["mean_torque"][-50:]) == pytest.approx(2.0, rel=0.02)
    current = np.hypot(run["motor_current_alpha"], run["motor_current_beta"])
    assert np.mean(current[-500:]) == pytest.approx(2.0 / constant, rel=0.01)


def test_energy_goes_in_and_is_accounted_for():
    motor = replace(AFS_MOTOR, warming=COLD)
    time = np.arange(600) * 1e-3
    run = Run(MotorBench(motor), 600, request=1.2 * np.sin(25.0 * time), load_damping=0.01)
    machine, current = motor.machine, np.array([run["motor_current_alpha"], run["motor_current_beta"]])
    speed, voltage = run["motor_speed"], np.array([run["motor_voltage_alpha"], run["motor_voltage_beta"]])
    middle = 0.5 * (current[:, 1:] + current[:, :-1])
    electric = PERIOD * np.sum(1.5 * voltage[:, 1:] * middle)
    heat = PERIOD * np.sum(1.5 * machine.resistance * middle**2)
    viscous = PERIOD * np.sum((machine.damping + 0.01) * speed**2)
    dry = 1e-3 * np.sum(run["truth_motor_friction_torque"] * speed[::10])
    stored = 0.5 * machine.inertia * speed[-1] ** 2 + 0.75 * machine.inductance_d * np.sum(current[:, -1] ** 2)
    assert electric == pytest.approx(heat + viscous + dry + stored, rel=0.01)
    assert 0.1 < (viscous + dry) / electric < 0.9


def test_current_and_voltage_stay_within_their_limits():
    run = Run(MotorBench(smooth()), 1500, request=100.0)
    current = np.hypot(run["motor_current_alpha"], run["motor_current_beta"])
    voltage = np.hypot(run["motor_target_voltage_alpha"], run["motor_target_voltage_beta"])
    longest = IDEAL.modulation * longest_voltage(IDEAL.supply_voltage)
    assert np.max(voltage) <= longest * (1.0 + 1e-6)
    assert np.max(current) < 1.1 * AFS_MOTOR.control.current_limit
    assert 0.9 * longest < 0.034 * run["motor_speed"][-1] < longest


@pytest.mark.parametrize("error", [-0.4, 0.25])
def test_a_false_angle_turns_the_current_away(error):
    run = Run(MotorBench(smooth()), 100, request=1.0, locked=1.0, sensor__offset=error / 4.0)
    assert run["motor_torque"][-1] == pytest.approx(math.cos(error), rel=2e-3)
    assert not np.any(run["motor_angle_mechanical"])


def test_a_stuck_angle_stops_the_motor():
    held = np.where(np.arange(800) < 400, 0.0, 1.0)
    run = Run(MotorBench(), 800, request=0.8, load_damping=0.005, sensor__held=held)
    assert run["motor_speed"][3999] > 40.0
    assert np.max(np.abs(run["motor_speed"][-500:])) < 20.0


def test_dead_time_and_drop_are_lost_and_learnt():
    motor = replace(smooth(), inverter=Inverter(dead_time=2e-6, forward_drop=0.7))
    run = Run(MotorBench(motor), 300, request=1.0, locked=1.0)
    lost = run["motor_target_voltage_beta"] - run["motor_voltage_beta"]
    assert lost[-1] == pytest.approx((13.0 * 0.02 + 0.7) * 2.0 / 3.0**0.5, rel=1e-6)
    assert run["motor_torque"][-1] == pytest.approx(1.0, rel=2e-3)


def test_the_winding_warms_up_to_the_closed_form():
    warming = Warming(winding_capacity=0.5, housing_capacity=0.4, ambient_temperature=293.15)
    motor = replace(smooth(flux=AFS_MOTOR.machine.flux), warming=warming)
    run = Run(MotorBench(motor), 12_000, request=0.5, locked=1.0)
    current = 0.5 / TORQUE_CONSTANT
    rise = 1.0 / warming.winding_conductance + 1.0 / warming.housing_conductance
    cold_heat = 1.5 * 0.05 * current**2
    expected = cold_heat * rise / (1.0 - cold_heat * rise / 255.0)
    assert run["motor_temperature"][-1] - 293.15 == pytest.approx(expected, rel=0.01)
    assert run["truth_motor_resistance"][-1] == pytest.approx(0.05 * (1.0 + expected / 255.0), rel=0.01)
    assert run["truth_motor_flux"][-1] < motor.machine.flux


def test_float_steps_agree_with_the_kernel():
    block = MotorBench()
    inputs = {"request": 0.8, "load": 0.2, "sensor.gain": 1.0, "sensor.offset": 0.01}
    run = Run(block, 15, **{name.replace(".", "__"): value for name, value in inputs.items()})
    names = [name for name, _ in leaves(skeleton(block.Sample))]
    sample = rebuild(skeleton(block.Sample), [inputs.get(name, 0.0) for name in names])
    state = block.init()
    for expected in run.result.values:
        state, out = block.step(state, sample)
        np.testing.assert_allclose([value for _, value in leaves(out)], expected, rtol=1e-8, atol=1e-10)


def test_a_period_is_of_second_order():
    """The error of a millisecond at 250 electrical rad/s and 5 V falls by four with half the period."""
    machine, winding = smooth().machine, Winding(0.05, 0.0085)

    def after(count):
        now = begin(machine, Rotor(0.3, 60.0), StatorVector(0.004, 0.007), 0.0, winding)
        for _ in range(count):
            now, _ = advance(machine, now, StatorVector(-3.0, 4.0), winding, 1e-3 / count, 0.0, lambda *_: 0.1, 1.0)
        return np.array([*now.current, *now.rotor])

    exact = after(2000)
    ratio = (after(10) - exact) / (after(20) - exact)
    np.testing.assert_allclose(ratio, 4.0, rtol=0.25)
