"""The foreign column against closed forms, and its sources against their imports."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest

from tierod_lab.papers.foreign import rubbing_column as plant
from tierod_lab.papers.foreign.rubbing_column import LUGRE, MAXWELL, SIGNALS, STEP, Course, RubbingCar, driven


def test_it_imports_nothing_of_the_project():
    tree = ast.parse(Path(plant.__file__).read_text(encoding="utf-8"))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {each.name for node in ast.walk(tree) if isinstance(node, ast.Import) for each in node.names}
    assert not [each for each in modules if each.startswith("tierod")]


@pytest.mark.parametrize("kind", [plant._LuGre, plant._Maxwell])
def test_friction_settles_at_its_stribeck_level(kind):
    law, rate = kind(RubbingCar(LUGRE, 5.0)), -0.15
    for _ in range(4000):
        torque = law.torque(rate)
    level = 5.0 * (1.0 + 0.1 * math.exp(-((rate / 0.3) ** 2)))
    assert torque == pytest.approx(math.copysign(level, rate), rel=0.02)


@pytest.mark.parametrize("kind", [plant._LuGre, plant._Maxwell])
def test_friction_loses_energy_over_a_cycle_and_holds_at_rest(kind):
    car = RubbingCar(LUGRE, 5.0)
    law, work = kind(car), 0.0
    for k in range(8000):
        rate = 0.6 * math.cos(2.0 * math.pi * k * STEP)
        work += law.torque(rate) * rate * STEP * (k >= 4000)
    stroke = 2.0 * 0.6 / (2.0 * math.pi) * 2.0  # two seconds, two periods, four strokes of twice the amplitude
    assert 0.8 * 5.0 * 2.0 * stroke < work < 1.1 * 1.1 * 5.0 * 2.0 * stroke
    held = law.torque(0.0)
    assert law.torque(0.0) == pytest.approx(held)


def test_a_steady_bend_is_that_of_the_linear_single_track():
    """V = 20 m/s, small angle: yaw rate V delta / (L + K V^2) with the understeer of both axles."""
    car, speed, steer = RubbingCar(MAXWELL, 1e-3), 20.0, 0.15
    count = round(20.0 / STEP)
    seen = driven(car, Course(np.full(count, steer), np.full(count, speed)), 0)[-200:].mean(axis=0)
    wheel, yaw, lateral = (
        seen[list(SIGNALS).index(name)] for name in ("steering_wheel_angle", "yaw_rate", "lateral_acceleration")
    )
    bar = seen[list(SIGNALS).index("driver_torque")]
    length = car.front + car.rear
    gradient = car.mass / length * (car.rear / car.front_stiffness - car.front / car.rear_stiffness)
    pinion = wheel - bar / car.shaft
    assert yaw == pytest.approx(speed * pinion * car.ratio / (length + gradient * speed**2), rel=0.03)
    assert lateral == pytest.approx(speed * yaw, rel=0.02)
