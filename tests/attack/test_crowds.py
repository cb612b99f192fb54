"""Two and twenty processes at once on what they share: no lost update, no wrong refusal, no crash."""

import pytest

from attack.crowds import CROWDS, commands


@pytest.mark.parametrize("count", [pytest.param(2, marks=pytest.mark.slow), 20])
@pytest.mark.parametrize("shared", CROWDS)
def test_a_crowd_loses_nothing_and_refuses_nothing_wrongly(tmp_path, shared, count):
    found = CROWDS[shared](count, seed=count, folder=tmp_path)
    assert found["processes"] == count
    assert found["wrong"] == 0, found


@pytest.mark.slow
def test_twenty_commands_at_once_count_each_recording_once(tmp_path):
    found = commands(20, seed=3, folder=tmp_path)
    assert found == {"processes": 20, "counted": 15, "refused": 5, "wrong": 0}
