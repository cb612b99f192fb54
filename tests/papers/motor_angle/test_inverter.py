from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.motor_angle.inverter import LOSSY, identified, items, said_wrong
from tierod_lab.papers.motor_angle.observer_drives import to_and_fro
from tierod_lab.studies.effort import Effort


def test_a_quick_run_shows_every_claim_and_meets_it():
    found = list(items(Effort(quick=True)))
    claims = {each.id: each for each in found if isinstance(each, Claim)}
    assert set(claims) == {
        f"motor-angle.commanded.{name}" for name in ("identified", "learnt", "wrong-knee-said", "right-knee-kept")
    }
    assert all(each.met for each in claims.values())
    table = next(each for each in found if isinstance(each, Table) and each.title.startswith("Error"))
    rms = {row[0]: float(row[2]) for row in table.rows}
    assert rms["command taken for the voltage"] > 1.0
    assert rms["held, knee 2 A assumed"] > 3.0 * rms["loss and knee identified"]


def test_an_inverter_identified_from_another_drive_is_not_called_wrong():
    fit = identified(to_and_fro(4900, 8.0, inverter=LOSSY))
    seen = to_and_fro(4900 + 1, 8.0, inverter=LOSSY)
    assert not said_wrong(seen, fit.knee)
    assert said_wrong(seen, 3.0 * fit.knee)
