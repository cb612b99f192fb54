"""Seeds of reported drives: they change with the judged monitor, and none was driven while it was tuned."""

from dataclasses import replace
from importlib import import_module

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.papers.friction.reported import SEEDS as FRICTION
from tierod_lab.papers.friction.reported import monitor
from tierod_lab.papers.seeds import APART, ReportedSeeds

STUDIES = (
    *("friction.reported", "motor_angle.study", "sideslip.study", "column.study"),
    *("fleet.study", "own_car.study"),
)


def seeds(*blocks):
    return ReportedSeeds(lambda: blocks, {"one": 0, "two": 7}, "a monitor")


def test_a_changed_threshold_draws_other_drives():
    usual = monitor()
    stricter = replace(usual, verdict=replace(usual.verdict, tuning=replace(usual.verdict.tuning, rising_ratio=1.3)))
    assert seeds(usual).first == seeds(monitor()).first == FRICTION.first
    assert seeds(stricter).first != FRICTION.first


def test_parts_count_on_from_where_they_begin():
    each = seeds(monitor())
    assert each.first % APART == 0
    assert each.of("two", 3) == range(each.first + 7, each.first + 10)
    with pytest.raises(ParameterError, match="no part 'tow'.*two"):
        each.of("tow", 1)
    with pytest.raises(ParameterError, match="do not fit into a block"):
        each.of("two", APART)


def test_a_study_prints_its_seeds():
    table = seeds(monitor()).table()
    assert table.rows == (("one", f"{FRICTION.first}"), ("two", f"{FRICTION.first + 7}"))
    assert "a monitor" in table.note


@pytest.mark.parametrize("name", STUDIES)
def test_no_reported_drive_was_driven_while_tierod_was_tuned(name):
    found = import_module(f"tierod_lab.papers.{name}").SEEDS
    assert found.first >= APART
    begins = sorted(found.parts.values())
    assert len(set(begins)) == len(begins)
    assert begins[-1] < APART
