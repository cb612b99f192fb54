"""Which faults the equations isolate, and what stands in for each sensor."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.analysis.structure import gain_of_sensors, isolability
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.reaction import FILTER, Reconfiguration, plain_relations, substitution_graph
from tierod.monitors.condition.signals import (
    ACTUATORS,
    FRONT_WHEELS,
    OF_AUTOMATED,
    PLACES,
    SENSORS,
    ConditionSample,
    further_sensors,
    limitations,
    vehicle_structure,
)
from tierod.vehicles import load

VEHICLE = load("smartload")


def test_the_steering_motors_are_distinguished_by_the_current_of_one_only():
    model = vehicle_structure(VEHICLE)
    assert set(model.faults) == {*OF_AUTOMATED, *ACTUATORS}
    assert isolability(model).mistaken_for("steering_motor_1") == ("steering_motor_2",)
    gains = {gain.sensor: gain.isolated_pairs for gain in gain_of_sensors(model, further_sensors(model))}
    helpful = {sensor for sensor, result in gains.items() if result}
    assert helpful == {f"torque of steering motor {k}, from its current" for k in (1, 2)}


def test_detectable_and_isolable_faults_are_those_of_the_toolbox():
    toolbox = pytest.importorskip("faultdiagnosistoolbox")
    missing = ("tie_rod_force", "lateral_acceleration", "longitudinal_acceleration")
    model = vehicle_structure(VEHICLE, missing, forces_known=False)
    rows = [[*sorted(each.unknowns), *([f"fault_{each.fault}"] if each.fault else [])] for each in model.equations]
    faults = [f"fault_{name}" for name in model.faults]
    theirs = toolbox.DiagnosisModel({"type": "VarStruc", "x": list(model.unknowns), "f": faults, "z": [], "rels": rows})
    found = isolability(model)
    detectable, _ = theirs.DetectabilityAnalysis()
    assert set(detectable) == {f"fault_{name}" for name in found.faults if name not in found.undetectable}
    assert np.array_equal(found.mistaken, np.asarray(theirs.IsolabilityAnalysis()) > 0.5)


CAR_LACKS = ["steering_shaft_torque", "tie_rod_force", *FRONT_WHEELS]


@pytest.mark.parametrize(
    ("vehicle", "missing", "sentence"),
    [
        ("rav4", CAR_LACKS, "single faults of wheel speed rear left, .* are still distinguished by the equations"),
        (
            "revsted-car",
            ["yaw_rate", "longitudinal_acceleration", "lateral_acceleration", *FRONT_WHEELS],
            "faults of wheel speed rear left, wheel speed rear right and steering wheel angle are not distinguished",
        ),
        (
            "rav4",
            [*(name for name in SENSORS if name != "wheel_speed_rear_left"), "lateral_acceleration"],
            "faults of wheel speed rear left do not show in any equation",
        ),
        (
            "smartload",
            ["steering_shaft_torque"],
            "^without steering shaft torque, faults of steering motor 1 and steering motor 2 are not distinguished",
        ),
    ],
)
def test_what_is_not_distinguished_without_some_sensors_is_named(vehicle, missing, sentence):
    assert re.search(sentence, limitations(load(vehicle), missing)[0])


@pytest.mark.parametrize(
    ("vehicle", "without", "message"),
    [("smartload", ["yaw"], r"no sensor 'yaw'.*yaw_rate"), ("ferrari-250lm", [], r"lacks track_width\. ")],
)
def test_a_sensor_that_does_not_exist_and_a_vehicle_without_its_track_are_refused(vehicle, without, message):
    with pytest.raises(ParameterError, match=message):
        vehicle_structure(load(vehicle), without)


CAR = VEHICLE.parameters_for(AutomatedVehicle.Parameters)
EXACT = replace(CAR, wheel_speed_difference=0.01, yaw_rate_offset=0.002, steering_wheel_angle_offset=0.03)


def circle(speed=3.0, radius=30.0, car=EXACT):
    """Readings of a slow circle without slip: wheels roll, the force on the tie rods balances torque and springs."""
    turning, torque = speed / radius, 4.0
    angle = math.atan((car.front_distance + car.rear_distance) / radius) / car.steering_ratio
    half = 0.5 * car.wheel_speed_difference
    values = dict.fromkeys(ConditionSample._fields, 0.0) | {
        "wheel_speed_rear_left": (speed - 0.5 * car.track_width * turning) * car.wheel_speed_scale * (1.0 - half),
        "wheel_speed_rear_right": (speed + 0.5 * car.track_width * turning) * car.wheel_speed_scale * (1.0 + half),
        "yaw_rate": turning + car.yaw_rate_offset,
        "steering_wheel_angle": angle + car.steering_wheel_angle_offset,
        "steering_shaft_torque": torque + car.steering_shaft_torque_offset,
        "tie_rod_force": torque / car.rack_ratio
        - car.rack_ratio * car.rack_stiffness * angle
        + car.tie_rod_force_offset,
        "steering_motor_1_target_torque": 0.6 * torque,
        "steering_motor_2_target_torque": 0.4 * torque,
    }
    return ConditionSample(**values)


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_substitutes_are_the_filter_and_relations_that_agree_with_a_slow_circle(sensor):
    first, *ways = substitution_graph().substitutes[sensor]
    relations = plain_relations(circle(), EXACT)[sensor]
    assert first.name == FILTER
    assert {way.name for way in ways} == set(relations)
    for way in ways:
        # An angle follows from a small-angle relation, and by the slight understeer of the vehicle file.
        assert relations[way.name] == pytest.approx(getattr(circle(), sensor), rel=0.02, abs=1e-3)
        for other in OF_AUTOMATED:
            moved = plain_relations(circle()._replace(**{other: 77.0}), EXACT)[sensor][way.name]
            assert (moved != relations[way.name]) == (other in way.needs), (way.name, other)


def supplied(block, filtered, lost):
    """What stands in for a yaw rate that is declared for 40 samples, while the left wheel is from sample 20 on."""
    readings = np.tile(np.array(circle(car=CAR)), (40, 1))
    faulty, values = np.zeros((40, len(SENSORS))), readings[:, PLACES] * 1.001
    faulty[:, 2], faulty[20:, 0] = 1.0, float(lost)
    values[20:25] = values[20:25] if filtered else np.nan
    return scan(block, np.hstack([readings, faulty, values]))["yaw_rate.source"][[0, 19, 20, 24, 25]].tolist()


def test_a_declared_sensor_is_replaced_by_the_filter_and_without_it_by_a_relation_of_fault_free_sensors():
    assert supplied(Reconfiguration.of_vehicle(VEHICLE), False, False) == [1.0, 1.0, 2.0, 2.0, 1.0]
    assert supplied(Reconfiguration.of_vehicle(VEHICLE, filters=False), True, True) == [1.0, 1.0, -1.0, -1.0, -1.0]
