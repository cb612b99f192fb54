"""Which sentence a drive and a vehicle file that do not fit each other bring."""

import math

import pytest

from tierod.monitors.driver_torque.column import ColumnGeometry
from tierod.monitors.driver_torque.evidence import Drive
from tierod.monitors.driver_torque.facts import INERTIA_SPREAD, FitRules, judge, misfits
from tierod.vehicles import load

VEHICLE = load("column-bench")
RULES = FitRules()


def drive(inertia_error=0.0, nis=1.0, seen=True):
    right = dict.fromkeys(ColumnGeometry._fields, 0.0) | {
        "ratio": VEHICLE["motor_ratio"],
        "stiffness": VEHICLE["torsion_bar_stiffness"],
    }
    plain = dict.fromkeys(Drive._fields, 0.0) | {"motor_inertia": None, "turned": (), "stretches": (), "doubts": ()}
    geometry = ColumnGeometry(**right) if seen else None
    return Drive(**plain | {"geometry": geometry, "nis": nis, "inertia_error": inertia_error, "contradiction": None})


OFF = 20.0 * INERTIA_SPREAD * VEHICLE["steering_wheel_inertia"]


@pytest.mark.parametrize(
    ("inertia_error", "nis", "seen", "begins"),
    [
        (0.0, 1.0, True, []),
        (OFF, 1.0, True, ["inertia"]),
        (0.0, 1e4, True, ["innovations"]),
        (OFF, 1e4, True, ["inertia"]),
        (OFF, 1e4, False, ["inertia", "innovations"]),
        (0.0, 1e4, False, ["innovations"]),
        (0.0, math.nan, False, []),
    ],
)
def test_innovations_are_named_where_nothing_else_explains_them(inertia_error, nis, seen, begins):
    found = misfits(drive(inertia_error, nis, seen), VEHICLE, RULES)
    assert [each.name for each in found] == begins


@pytest.mark.parametrize(("nis", "doubted"), [(1.0, False), (3.0, False), (4.08, True), (math.nan, False)])
def test_innovations_that_are_too_large_to_believe_the_deviation_are_remarked_upon(nis, doubted):
    moved = drive(nis=nis)._replace(ready=60.0, torque_span=4.0, angle_span=1.0, hand_rms=1.0, hand_deviation=0.1)
    verdict = judge(moved, VEHICLE, "driver-torque", RULES)
    assert verdict.status.quiet
    assert any("2.0 times as large" in each.cause for each in verdict.facts) is doubted
