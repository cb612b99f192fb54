"""Names and hypotheses of the condition monitor, and which of their faults its equations isolate."""

from math import comb

import numpy as np
import pytest

from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.core.signals import SIGNALS
from tierod.methods.analysis.structure import gain_of_sensors, isolability
from tierod.monitors.condition.signals import (
    ACTUATORS,
    FRONT_WHEELS,
    HEALTHY,
    OF_AUTOMATED,
    ConditionSample,
    hypotheses,
)
from tierod.monitors.condition.structure import further_sensors, limitations, rolls, vehicle_structure
from tierod.vehicles import load, shipped


def test_every_signal_is_canonical_with_its_unit():
    for name, unit in zip(ConditionSample._fields, units(ConditionSample), strict=True):
        assert SIGNALS[name].unit == unit


def test_the_hypotheses_are_all_singles_and_pairs_and_of_two_actuators_those_that_share_a_supply():
    every = hypotheses()
    assert every[0].name == HEALTHY
    assert every[0].suspects == ()
    sensors, actuators = len(OF_AUTOMATED), len(ACTUATORS)
    assert len(every) == 3 + sensors + actuators + comb(sensors, 2) + sensors * actuators
    assert len({frozenset(each.suspects) for each in every}) == len({each.name for each in every}) == len(every)
    assert all(len(each.suspects) <= 2 for each in every)
    together = [each.name for each in every if len(each.actuators) > 1]
    assert together == ["steering_motor_1 + steering_motor_2", "drive_left + drive_right"]
    assert all(set(each.sensors) <= set(OF_AUTOMATED) and set(each.actuators) <= set(ACTUATORS) for each in every)


CAR = load("smartload")


@pytest.mark.parametrize("forces_known", [True, False])
def test_every_fault_has_its_equation(forces_known):
    model = vehicle_structure(CAR, forces_known=forces_known)
    assert set(model.faults) == {*OF_AUTOMATED, *ACTUATORS}


def test_the_steering_motors_are_distinguished_by_the_current_of_one_only():
    model = vehicle_structure(CAR)
    assert isolability(model).mistaken_for("steering_motor_1") == ("steering_motor_2",)
    gains = {gain.sensor: gain.isolated_pairs for gain in gain_of_sensors(model, further_sensors(model))}
    helpful = {sensor for sensor, result in gains.items() if result}
    assert helpful == {f"torque of steering motor {k}, from its current" for k in (1, 2)}


@pytest.mark.parametrize("without", [(), ("tie_rod_force", "lateral_acceleration", "longitudinal_acceleration")])
def test_detectable_and_isolable_faults_are_those_of_the_toolbox(without):
    toolbox = pytest.importorskip("faultdiagnosistoolbox")
    model = vehicle_structure(CAR, without, forces_known=False)
    rows = [[*sorted(each.unknowns), *([each.fault] if each.fault else [])] for each in model.equations]
    faults = [f"fault_{name}" for name in model.faults]
    rows = [
        [*row[:-1], f"fault_{row[-1]}"] if each.fault else row for each, row in zip(model.equations, rows, strict=True)
    ]
    theirs = toolbox.DiagnosisModel({"type": "VarStruc", "x": list(model.unknowns), "f": faults, "z": [], "rels": rows})
    found = isolability(model)
    detectable, _ = theirs.DetectabilityAnalysis()
    assert set(detectable) == {f"fault_{name}" for name in found.faults if name not in found.undetectable}
    assert np.array_equal(found.mistaken, np.asarray(theirs.IsolabilityAnalysis()) > 0.5)


def test_a_sensor_that_does_not_exist_is_refused():
    with pytest.raises(ParameterError, match=r"no sensor 'yaw'.*yaw_rate"):
        vehicle_structure(CAR, ["yaw"])


def test_with_four_sensors_every_single_fault_of_a_car_is_reported():
    (result,) = limitations(load("rav4"), ["steering_shaft_torque", "tie_rod_force", *FRONT_WHEELS])
    lack = "without steering shaft torque, tie rod force, wheel speed front left and wheel speed front right"
    assert result.startswith(f"{lack}, single faults of wheel speed rear left")
    assert result.endswith("are still distinguished by the equations")


def test_without_yaw_rate_and_accelerations_three_stay_ambiguous():
    missing = ["yaw_rate", "longitudinal_acceleration", "lateral_acceleration", *FRONT_WHEELS]
    first, pairs = limitations(load("revsted-car"), missing)
    alike = (
        "wheel speed rear left, wheel speed rear right and steering wheel angle are not distinguished from each other"
    )
    assert first.endswith(f"faults of {alike}")
    assert pairs.startswith("of 3 pairs of faults 3 are not distinguished from others")


def test_a_single_sensor_is_checked_by_nothing():
    missing = ["wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle", "longitudinal_acceleration"]
    result = limitations(load("rav4"), [*missing, "lateral_acceleration", *FRONT_WHEELS])
    assert result[0].endswith("faults of wheel speed rear left do not show in any equation")


def test_the_steering_motors_stay_alike_without_their_torque():
    result = limitations(load("smartload"), ["steering_shaft_torque"])
    assert (
        result[0]
        == "without steering shaft torque, faults of steering motor 1 and steering motor 2 are not distinguished from "
        "each other"
    )


def test_cars_without_torques_are_reported_what_their_motion_lacks_and_nothing_else():
    assert {name for name in ("rav4", "revsted-car", "smartload") if rolls(load(name))} == {"rav4", "revsted-car"}
    assert "ferrari-250lm" in shipped()
    with pytest.raises(ParameterError, match=r"lacks track_width\. "):
        vehicle_structure(load("ferrari-250lm"))
