"""The monitor with all terms of eq (19): its parameters from a vehicle file, and what the terms do to an estimate."""

from dataclasses import replace

import numpy as np
import pytest

from models.friction_paper import CAR
from tierod.core.graph import scan
from tierod.vehicles import load
from tierod_lab.papers.friction.linearised import VariableRatioParameters, linearised

GROWTH, FRICTION = 0.06, 6.0


def test_the_growth_of_the_ratio_comes_from_the_vehicle_file():
    vehicle = load("midsize-eps")
    assert linearised(vehicle.parameters_for(VariableRatioParameters)).filter.parameters.steering_ratio_growth == 0.0
    known = replace(vehicle.parameters["steering_ratio"], name="steering_ratio_growth", value=GROWTH)
    grown = replace(vehicle, parameters={**vehicle.parameters, "steering_ratio_growth": known})
    monitor = linearised(grown.parameters_for(VariableRatioParameters))
    assert monitor.filter.parameters.steering_ratio_growth == GROWTH
    assert linearised(CAR, steering_ratio_growth=0.1).filter.parameters.steering_ratio_growth == 0.1


def samples(seconds=120.0):
    time = 0.01 * np.arange(round(100.0 * seconds))
    angle, rate = 1.5 * np.sin(0.5 * time), 0.75 * np.cos(0.5 * time)
    acceleration = -0.375 * np.sin(0.5 * time)
    lateral = 2.0 * angle
    aligning = CAR.trail * CAR.rear_distance * CAR.mass * lateral / (CAR.front_distance + CAR.rear_distance)
    ratio = CAR.steering_ratio * (1.0 + GROWTH * angle**2)
    total = CAR.column_inertia * acceleration + CAR.column_damping * rate + FRICTION * np.sign(rate) + ratio * aligning
    motor = 0.4 * total / CAR.motor_ratio
    return np.column_stack([angle, rate, total - CAR.motor_ratio * motor, motor, np.zeros(len(time)), lateral])


@pytest.mark.parametrize("sign_slope", [0.0, 1.0])
def test_with_the_right_ratio_the_friction_is_found(sign_slope):
    seen = samples()
    found = {}
    for growth in (0.0, GROWTH):
        monitor = linearised(CAR, steering_ratio_growth=growth, with_sign_slope=sign_slope)
        found[growth] = scan(monitor, seen)["friction_torque"][-1]
    assert found[GROWTH] == pytest.approx(FRICTION, abs=0.6)
    assert abs(found[GROWTH] - FRICTION) <= abs(found[0.0] - FRICTION) + 0.05
