"""The bank of a vehicle that nobody has calibrated: it reckons with what its predictions are off by."""

from dataclasses import replace

from tierod.monitors.condition.bank.judge import condition_bank
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.calibration.limits import limits_of
from tierod.monitors.condition.signals import SENSORS
from tierod.monitors.condition.substitutes import FILTER, substitution_graph
from tierod.monitors.condition.uncalibrated import unsure
from tierod.vehicles import load

CAR = load("smartload")


def test_every_kind_reckons_with_the_measured_error_and_nothing_else_changes():
    bank = condition_bank(LeaveOutFilter.of_vehicle(CAR), limits_of(CAR))
    after = unsure(bank)
    ways = substitution_graph(calibrated=False).substitutes
    for name, kind, before in zip(SENSORS, after.judge.kinds, bank.judge.kinds, strict=True):
        (error,) = (way.deviation for way in ways[name] if way.name == FILTER)
        assert before.unknown == 0.0
        assert kind == replace(before, unknown=error)
    assert after.lanes == bank.lanes
    assert after.judge.decision == bank.judge.decision
