"""What recordings of a real drive show, and what is said without them."""

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.motor_angle import real_drives
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.studies.effort import Effort


@pytest.fixture
def here(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("pmsm_drive").parent))


def test_without_recordings_it_says_so_and_measures_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    claims = [item for item in real_drives.items(Effort()) if isinstance(item, Claim)]
    assert len(claims) == 7
    assert {claim.note for claim in claims} == {NO_DATA}
    assert all(claim.measured is None for claim in claims)


def test_the_wrong_sign_of_the_current_is_recognised(here):
    recording = real_drives.recorded(real_drives.DRAGGED)
    said = real_drives.refused(real_drives.with_sign(recording, 1.0))
    assert "resistance is estimated at -0.2" in said
    assert "sign = -1" in said
    assert real_drives.refused(real_drives.with_sign(recording, -1.0)) == ""


def test_the_observers_agree_with_the_drive_only_with_the_current_turned_round(here):
    items = list(real_drives.dragged(real_drives.recorded(real_drives.DRAGGED)))
    table = next(item for item in items if isinstance(item, Table))
    away = {row[:2]: float(row[2].replace("−", "-")) for row in table.rows}
    assert abs(away["default, resistance and flux held", "turned round"]) < 0.1
    assert abs(away["default, resistance and flux held", "as recorded"]) > 0.5
    claims = {item.id: item for item in items if isinstance(item, Claim)}
    assert all(claim.met for claim in claims.values())


def test_the_other_recordings_hold_their_claims(here):
    claims = [item for item in real_drives.items(Effort()) if isinstance(item, Claim)]
    assert [claim.id for claim in claims if not claim.met] == []


def test_agreement_is_that_of_angles_that_wrap():
    angle = np.linspace(0.0, 40.0, 500)
    found = real_drives.agreement(np.mod(angle + 3.0, 2.0 * np.pi), np.mod(angle, 2.0 * np.pi))
    assert found.mean == pytest.approx(3.0)
    assert found.deviation == pytest.approx(0.0, abs=1e-9)
