import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.condition import residuals
from tierod_lab.studies.effort import Effort


@pytest.mark.slow
def test_faults_are_seen_by_residuals_that_use_the_sensor_and_by_no_others():
    found = list(residuals.items(Effort(quick=True, processes=1)))
    claims = {each.id: each for each in found if isinstance(each, Claim)}
    assert all(claim.met for claim in claims.values())
    signatures, compared, disagreements, thresholds, rules = (each for each in found if isinstance(each, Table))
    assert len(compared.rows) == 31
    assert disagreements.rows
    lost = dict(
        zip(signatures.header, next(row for row in signatures.rows if row[0].endswith("left loss")), strict=True)
    )
    assert {name for name in ("r7", "r8", "r9", "r10", "r11", "r13", "r15") if lost[name] == "1.00"} >= {"r7", "r10"}
    assert lost["r14"] == lost["r19"] == ""
    assert len(thresholds.rows) == 31
    assert [row[0] for row in rules.rows] == ["fixed", "adapting"]
