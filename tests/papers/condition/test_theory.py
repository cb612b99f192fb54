"""Structure against made-up measurements: who agrees, who does not, and why."""

from collections import Counter

import pytest

from tierod.methods.analysis.structure import isolability
from tierod.monitors.condition.structure import vehicle_structure
from tierod.vehicles import load
from tierod_lab.papers.condition.scoring import AMBIGUOUS, NEVER, UNNAMED
from tierod_lab.papers.condition.theory import Compared, compared, disagreements, reason, table

YAW = Compared("yaw_rate", "isolable", (), {})
MOTOR = Compared("steering_motor_1", "not isolable from steering motor 2", ("steering_motor_2",), {})
PAIR = Compared("yaw_rate + tie_rod_force", "isolable", (), {})


@pytest.mark.parametrize(
    ("fault", "named"),
    [(YAW, "yaw_rate"), (MOTOR, "steering_motor_2"), (MOTOR, AMBIGUOUS), (PAIR, "yaw_rate + tie_rod_force")],
)
def test_what_structure_foretells_needs_no_reason(fault, named):
    assert reason(fault, named) == ""


@pytest.mark.parametrize(
    ("fault", "named", "why"),
    [
        (YAW, NEVER, "not its size"),
        (YAW, UNNAMED, "below the limits"),
        (YAW, AMBIGUOUS, "almost as well"),
        (YAW, "steering_wheel_angle", "regards no magnitudes"),
        (MOTOR, "steering_motor_1", "regards no time"),
        (MOTOR, "drive_left", "regards no magnitudes"),
        (PAIR, "yaw_rate", "a second fault hypothesis"),
    ],
)
def test_every_disagreement_has_a_reason(fault, named, why):
    assert why in reason(fault, named)


def test_rules_have_reasons_of_their_own():
    assert "no rule fits" in reason(YAW, UNNAMED, "rules")
    assert "several rules fit" in reason(YAW, AMBIGUOUS, "rules")
    assert "the rule of another" in reason(YAW, "tie_rod_force", "rules")


def test_rows_hold_counts_in_words():
    known = YAW._replace(named={"bank": Counter({"yaw_rate": 5, AMBIGUOUS: 1})})
    assert table("title", [known]).rows == (("yaw rate", "isolable", "right 5, ambiguous 1"),)
    (row,) = disagreements([known])
    assert row[:4] == ("yaw rate", "isolable", "bank of filters", "1 of 6: ambiguous")


def test_structure_is_asked_about_pairs_by_any_order_of_names(monkeypatch):
    structure = isolability(vehicle_structure(load("smartload")), at_once=2)
    counts = {
        "yaw_rate + steering_motor_1": Counter(),
        "yaw_rate + drive_left": Counter(),
        "steering_motor_1": Counter(),
    }
    monkeypatch.setattr("tierod_lab.papers.condition.theory.confusion", lambda scores: counts)
    found = {each.fault: each for each in compared(structure, {"bank": []})}
    assert found["yaw_rate + steering_motor_1"].alike == ("yaw_rate + steering_motor_2",)
    assert found["yaw_rate + drive_left"].theory == "isolable"
    assert found["steering_motor_1"].alike == ("steering_motor_2",)
