from __future__ import annotations

import pytest

from tierod.studies import friction_paper
from tierod.studies.friction_paper import Table, hysteresis, levels, monitors, tables


def test_a_table_reads_as_markdown():
    table = Table("Two figures", ("a", "b"), (("1", "2"), ("3", "4")))
    assert table.markdown() == "Two figures\n\n| a | b |\n| --- | --- |\n| 1 | 2 |\n| 3 | 4 |\n"


def test_hysteresis_finds_what_was_added():
    for row in hysteresis().rows:
        found = [float(cell.split(" ± ")[0]) for cell in row[2:]]
        assert found == pytest.approx([0.0, 1.5, 4.0, 8.5], abs=0.3)


def test_levels_orders_the_levels_for_every_estimator(monkeypatch):
    monkeypatch.setattr(friction_paper, "SEEDS", (1,))
    table = levels(1.0)
    assert len(table.rows) == len(monitors())
    for row in table.rows:
        means = [float(cell.split(" ± ")[0]) for cell in row[1:]]
        assert means == sorted(means)
        assert means[0] < friction_paper.THRESHOLD < means[-1]


@pytest.mark.slow
def test_every_table_can_be_made():
    made = list(tables())
    assert len(made) == 9
    for table in made:
        assert all(len(row) == len(table.header) for row in table.rows)
