"""What stands in for each sensor: the graph is whole, the relations hold, and the block is the switch fed with them."""

import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.diagnosis.switchover import Switchover
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.reaction import (
    FADE,
    FILTER,
    GROWTH,
    Reconfiguration,
    plain_relations,
    substitution_graph,
)
from tierod.monitors.condition.signals import OF_AUTOMATED, PLACES, SENSORS, ConditionSample
from tierod.vehicles import load

VEHICLE = load("smartload")
CAR = VEHICLE.parameters_for(AutomatedVehicle.Parameters)
EXACT = replace(CAR, wheel_speed_difference=0.01, yaw_rate_offset=0.002, steering_wheel_angle_offset=0.03)
BASE = CAR.front_distance + CAR.rear_distance


def circle(speed=3.0, radius=30.0, car=EXACT):
    """Readings of a slow circle without slip: wheels roll, the force on the tie rods balances torque and springs."""
    turning = speed / radius
    angle = math.atan(BASE / radius) / car.steering_ratio
    torque = 4.0
    force = torque / car.rack_ratio - car.rack_ratio * car.rack_stiffness * angle
    half = 0.5 * car.wheel_speed_difference
    values = dict.fromkeys(ConditionSample._fields, 0.0) | {
        "wheel_speed_rear_left": (speed - 0.5 * car.track_width * turning) * car.wheel_speed_scale * (1.0 - half),
        "wheel_speed_rear_right": (speed + 0.5 * car.track_width * turning) * car.wheel_speed_scale * (1.0 + half),
        "yaw_rate": turning + car.yaw_rate_offset,
        "steering_wheel_angle": angle + car.steering_wheel_angle_offset,
        "steering_shaft_torque": torque + car.steering_shaft_torque_offset,
        "tie_rod_force": force + car.tie_rod_force_offset,
        "steering_motor_1_target_torque": 0.6 * torque,
        "steering_motor_2_target_torque": 0.4 * torque,
    }
    return ConditionSample(**values)


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_every_sensor_has_the_filter_first_and_plain_relations_after_it(sensor):
    ways = substitution_graph().substitutes[sensor]
    assert ways[0].name == FILTER
    assert ways[0].needs == ()
    assert {way.name for way in ways[1:]} == set(plain_relations(circle(), EXACT)[sensor])
    assert len(ways) > 1
    assert all(way.source for way in ways)


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_on_an_uncalibrated_vehicle_every_substitute_errs_more(sensor):
    known = {way.name: way for way in substitution_graph().substitutes[sensor]}
    for way in substitution_graph(calibrated=False).substitutes[sensor]:
        assert way.deviation >= known[way.name].deviation
        assert way.needs == known[way.name].needs
    assert substitution_graph(calibrated=False).substitutes[sensor][0].deviation > 0.99 * known[FILTER].deviation


@pytest.mark.parametrize("calibrated", [True, False])
def test_without_a_bank_plain_relations_are_left_with_their_own_errors(calibrated):
    whole, rest = (substitution_graph(calibrated, filters).substitutes for filters in (True, False))
    assert rest == {name: tuple(way for way in ways if way.name != FILTER) for name, ways in whole.items()}
    assert all(rest.values())


def test_any_two_lost_sensors_can_be_replaced():
    graph = substitution_graph()
    assert graph.sensors == OF_AUTOMATED
    for sensor, other in permutations(graph.sensors, 2):
        assert any(other not in way.needs for way in graph.substitutes[sensor])
    assert set(GROWTH) == set(SENSORS)


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_the_relations_agree_with_a_slow_circle(sensor):
    readings = circle()
    true = getattr(readings, sensor)
    for name, value in plain_relations(readings, EXACT)[sensor].items():
        # An angle follows from a small-angle relation, and by the slight understeer of the vehicle file.
        assert value == pytest.approx(true, rel=0.02, abs=1e-3), name


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_what_a_relation_does_not_need_it_does_not_use(sensor):
    for way in substitution_graph().substitutes[sensor][1:]:
        usual = plain_relations(circle(), EXACT)[sensor][way.name]
        for other in OF_AUTOMATED:
            moved = plain_relations(circle()._replace(**{other: 77.0}), EXACT)[sensor][way.name]
            assert (moved != usual) == (other in way.needs), (way.name, other)


@pytest.fixture(scope="module")
def block():
    return Reconfiguration.of_vehicle(VEHICLE)


def samples(count=40):
    """A circle with noise, one declared fault after another, and what a filter would say."""
    rng = np.random.default_rng(5)
    readings = np.array(circle(car=CAR)) * (1.0 + 0.01 * rng.standard_normal((count, len(ConditionSample._fields))))
    faulty = np.zeros((count, len(SENSORS)))
    for place in range(len(OF_AUTOMATED)):
        faulty[5 + 5 * place : 12 + 5 * place, place] = 1.0
    filtered = readings[:, PLACES] * 1.001
    filtered[20:25] = np.nan
    readings[30, 2] = np.nan
    return readings, faulty, filtered


def test_the_block_is_the_switch_fed_with_the_relations(block):
    readings, faulty, filtered = samples()
    result = scan(block, np.hstack([readings, faulty, filtered]))
    rows = []
    for reading, declared, said in zip(readings, faulty, filtered, strict=True):
        relations = plain_relations(ConditionSample(*reading), block.vehicle)
        row = []
        for place, (sensor, ways) in enumerate(substitution_graph().substitutes.items()):
            values = relations[sensor] | {FILTER: said[place]}
            row += [reading[place], declared[place], *(values[way.name] for way in ways)]
        rows.append(row)
    growth = tuple(GROWTH[name] for name in OF_AUTOMATED)
    by_hand = scan(Switchover(substitution_graph(), growth, FADE, 0.01), np.array(rows))
    np.testing.assert_allclose(result.values, by_hand.values, rtol=1e-12)


def test_without_a_bank_a_declared_sensor_is_replaced_by_a_relation_whose_sensors_are_fault_free():
    readings, faulty, filtered = samples()
    faulty[:] = 0.0
    faulty[:, 2] = 1.0
    faulty[20:, 0] = 1.0
    result = scan(Reconfiguration.of_vehicle(VEHICLE, filters=False), np.hstack([readings, faulty, filtered]))
    relation = plain_relations(ConditionSample(*readings[0]), CAR)["yaw_rate"]["rear-wheels"]
    assert result["yaw_rate.value"][0] == pytest.approx(relation)
    assert result["yaw_rate.deviation"][0] == substitution_graph(filters=False).substitutes["yaw_rate"][0].deviation
    assert result["yaw_rate.source"][[0, 19, 20]].tolist() == [1.0, 1.0, -1.0]


def test_a_declared_sensor_is_replaced_by_the_filter_and_without_it_by_the_next_best(block):
    readings, faulty, filtered = samples()
    faulty[:] = 0.0
    faulty[:, 2] = 1.0
    result = scan(block, np.hstack([readings, faulty, filtered]))
    assert result["yaw_rate.source"][[0, 19, 20, 24, 25]].tolist() == [1.0, 1.0, 2.0, 2.0, 1.0]
    np.testing.assert_array_equal(result["yaw_rate.value"][:20], filtered[:20, 2])
    assert result["steering_wheel_angle.source"].tolist() == [0.0] * 40
