from dataclasses import replace

from tierod.monitors.condition.definition import condition_monitor
from tierod.vehicles import load
from tierod_lab.campaign.code import reported_seed
from tierod_lab.papers.condition.reported import USED, first_vehicle, vehicles
from tierod_lab.studies.effort import Effort


def test_a_changed_threshold_draws_other_demonstrators():
    bank = condition_monitor(load("smartload"))
    lanes = tuple(replace(lane, bending=lane.bending * 1.01) for lane in bank.lanes)
    assert reported_seed(bank) != reported_seed(replace(bank, lanes=lanes))
    assert reported_seed(bank) == reported_seed(condition_monitor(load("smartload")))


def test_reported_demonstrators_are_none_of_those_that_thresholds_were_chosen_on():
    chosen = vehicles(Effort())
    assert chosen[0] == first_vehicle() > USED
    assert chosen == tuple(range(chosen[0], chosen[0] + 3))
    assert vehicles(Effort(quick=True)) == chosen[:1]
