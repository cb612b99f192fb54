"""Residuals' signatures by equation and by measurement, on shares made by hand."""

from tierod_lab.papers.condition.rules.parameters import RESIDUALS
from tierod_lab.papers.condition.signatures import Seen, disagreements, theory_and_measurement, uses


def made(**shares):
    return {name: Seen(shares.get(name, 0.0), 2.0 * shares.get(name, 0.1)) for name in RESIDUALS}


def test_an_equation_has_the_sensors_it_reads_and_the_actuators_behind_its_targets():
    assert uses("r7", "yaw_rate")
    assert not uses("r9", "yaw_rate")
    assert not any(uses(f"r{number}", "drive_left") for number in range(1, 20))
    assert uses("r6a", "steering_motor_1")
    assert not uses("r6a", "drive_left")
    assert uses("r7a", "drive_right")
    assert not uses("r7a", "steering_motor_2")


def test_the_best_kind_counts_and_both_ways_to_disagree_are_marked():
    seen = {
        ("yaw_rate", "loss"): made(r7=0.5, r2=0.01),
        ("yaw_rate", "offset"): made(r7=0.9, r9=0.2),
    }
    table = theory_and_measurement(seen)
    cells = {row[0]: row[1] for row in table.rows}
    assert table.header == ("residual", "yaw rate")
    assert (cells["r7"], cells["r2"], cells["r9"], cells["r13"]) == ("0.90", "unseen", "! 0.20", "")
    rows = {row[0]: row for row in disagreements(seen).rows}
    assert rows["r9"][2:4] == ("does not", "0.20 of the time")
    assert rows["r2"][2] == "sees it"
    assert "r7" not in rows
    assert "r13" not in rows
