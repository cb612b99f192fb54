import re

import pytest

from tierod.core.findings import Estimate
from tierod.report.gauge import gauge


def estimate(value=12.4, spread=0.1, **reference):
    return Estimate("friction", value, spread, "N*m", reference)


def test_marks_stand_where_their_values_are():
    drawing = gauge(estimate(nominal=4.0, fault=8.0))
    ticks = [float(x) for x in re.findall(r'<line x1="([\d.]+)"[^>]*stroke-width="2.5"', drawing)]
    dot = float(re.search(r'<circle cx="([\d.]+)"', drawing)[1])
    assert ticks[1] - 14.0 == pytest.approx(2.0 * (ticks[0] - 14.0), abs=0.2)
    assert (dot - 14.0) / (ticks[0] - 14.0) == pytest.approx(12.4 / 4.0, rel=1e-3)


def test_names_of_near_levels_stand_in_different_rows():
    drawing = gauge(estimate(nominal=4.0, learnt=4.05, rising=4.8, watch=5.0))
    rows = re.findall(r'<text x="[\d.]+" y="([\d.]+)"', drawing)
    assert len(set(rows)) == 4


@pytest.mark.parametrize("each", [estimate(), estimate(value=float("nan"), nominal=4.0)])
def test_nothing_to_compare_is_nothing_to_draw(each):
    assert gauge(each) == ""


def test_it_shows_its_content_to_those_who_do_not_see_it():
    assert 'aria-label="12.40 N·m (95 % interval 12.20 to 12.60) on a scale with nominal 4 N·m"' in gauge(
        estimate(nominal=4.0)
    )


def test_negative_values_and_an_unknown_spread_are_drawn():
    assert "circle" in gauge(estimate(value=-3.0, spread=float("nan"), nominal=4.0))
