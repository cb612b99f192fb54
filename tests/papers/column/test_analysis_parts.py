"""The parts of the study that need no long runs: every claim that has a goal meets it."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.claims import Claim, claims_document
from tierod.core.content import Heading
from tierod.methods.analysis.observability import unscaled_rank
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import SteeringColumn
from tierod_lab.papers.column import frequency, observability, reduction
from tierod_lab.papers.column.observability import rational_rank, single_angle_ranks
from tierod_lab.papers.column.parameter_sets import EIGENVALUES, member
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.page import StudyPage, render_study

EXPECTED = {
    observability: {"observability.with-disturbances": 5.0, "observability.artefact": 8.0},
    reduction: {"reduction.feed-through": 0.0929, "reduction.balanced-eigenvalues": 5e-5},
    frequency: {"frequency.resonance": 12.7},
}


@pytest.mark.parametrize("part", EXPECTED, ids=lambda part: part.__name__.rpartition(".")[2])
def test_a_part_meets_its_goals(part):
    items = list(part.items(Effort(quick=True)))
    claims = {item.id: item for item in items if isinstance(item, Claim)}
    assert isinstance(items[0], Heading)
    assert {name for name, claim in claims.items() if claim.met is False} <= {"observability.single-angle"}
    for name, figure in EXPECTED[part].items():
        assert claims[name].figure == pytest.approx(figure, rel=0.1)
    claims_document(list(claims.values()))
    assert "</html>" in render_study(StudyPage("column", "Column", "", {}, items))


def test_the_entries_that_nothing_gives_are_measured_and_not_met():
    claims = {item.id: item for item in observability.items(Effort(quick=True)) if isinstance(item, Claim)}
    single = claims["observability.single-angle"]
    assert (single.printed, single.figure, single.met) == (5.0, 6.0, False)
    assert single.note.startswith("Not reproducible: 0 of ")


def test_ranks_by_one_angle_are_counted_and_not_assumed():
    parted = replace(member(700.0, 8.0, 0.03), torsion_bar_stiffness=0.0)  # two bodies that see nothing of the third
    ranks = single_angle_ranks([linear_column(SteeringColumn, parted)])
    assert ranks["staircase"] == ranks["scaled matrix"] == {2: 1, 4: 1}
    assert sum(ranks["relative tolerances of 1e-16 to 1e-6"].values()) == 22


@pytest.mark.parametrize(
    ("stiffness", "ratio", "inertia"), [(700.0, 8.0, 0.03), (3100.0, 20.0, 0.04), (5500.0, 15.0, 0.05)]
)
def test_every_member_of_the_family_has_the_eigenvalues_of_the_table(stiffness, ratio, inertia):
    parameters = member(stiffness, ratio, inertia)
    found = np.sort_complex(np.linalg.eigvals(linear_column(SteeringColumn, parameters).A))
    np.testing.assert_allclose(found, np.sort_complex(np.array(EIGENVALUES)), atol=1e-6)
    assert min(vars(parameters).values()) > 0.0
    assert parameters.torsion_bar_stiffness / inertia == pytest.approx(stiffness)


def test_rational_arithmetic_rounds_nothing():
    tiny = LinearSystem.of([[0.0, 1e-30], [0.0, 0.0]], [[1.0, 0.0]])
    assert rational_rank(tiny) == 2
    assert unscaled_rank(tiny).rank == 1
    assert rational_rank(LinearSystem.of(np.diag([-1.0, -1.0]), [[1.0, 1.0]])) == 1
