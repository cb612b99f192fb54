"""What the parts of the study give: the paper's figures, ranks, tables, claims of their own names."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.core.claims import Claim, claims_document
from tierod.core.content import Chart, Table
from tierod_lab.papers.sideslip import bandwidth, limits, neutral_steer, paper, table
from tierod_lab.studies.effort import Effort

QUICK = Effort(quick=True)


@pytest.fixture(scope="module")
def paper_items():
    return list(paper.items(QUICK))


def claims(items):
    return {each.id: each for each in items if isinstance(each, Claim)}


def test_figures_6_to_10_are_drawn_from_one_drive(paper_items):
    charts = [each for each in paper_items if isinstance(each, Chart)]
    assert [chart.name for chart in charts] == [f"figure-{number}" for number in range(6, 11)]
    for chart in charts:
        for panel in chart.panels:
            assert all(np.isfinite(mark.y).all() and len(mark.x) == len(mark.y) > 1000 for mark in panel.marks)


def test_the_estimates_follow_the_truth_from_a_standing_start(paper_items):
    assert all(claim.met for claim in claims(paper_items).values())
    motion = next(each for each in paper_items if isinstance(each, Chart) and each.name == "figure-9")
    truth, estimated, _ = motion.panels[0].marks
    assert np.abs(np.array(estimated.y) - np.array(truth.y)).max() < 0.5


def test_ranks_are_claimed_as_the_paper_says():
    items = list(neutral_steer.items(QUICK))
    assert [claim.met for claim in claims(items).values()] == [True, True, True]
    (rows,) = [each.rows for each in items if isinstance(each, Table)]
    assert {row[3] for row in rows if row[0] == "1"} == {"1 of 2"}


@pytest.mark.slow
def test_all_parts_have_claims_of_their_own_names(paper_items):
    parts = (table.items, limits.items, bandwidth.items, neutral_steer.items)
    items = [*paper_items, *(each for part in parts for each in part(QUICK))]
    assert claims_document(list(claims(items).values()))
    assert len(claims(items)) == sum(isinstance(each, Claim) for each in items)
