"""Small slow cars with sensors of the motion alone: parking, walking pace and tight turns are no faults."""

import json

import pytest

from monitors.condition.small_car import QUADRICYCLE, backs_out, recordings
from tierod.cli import main
from tierod.core.findings import Status
from tierod.io.writers import write
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load


@pytest.fixture(scope="module")
def quadricycle(tmp_path_factory):
    """Vehicle file as a user begins it."""
    path = tmp_path_factory.mktemp("small") / "quadricycle.toml"
    known = {"mass": QUADRICYCLE.mass, "wheelbase": QUADRICYCLE.front + QUADRICYCLE.rear}
    known |= {"track_width": QUADRICYCLE.track, "steering_ratio": QUADRICYCLE.ratio}
    assert (
        main(["new", str(path), "--class", "quadricycle", *(f"{name}={value}" for name, value in known.items())]) == 0
    )
    return path


@pytest.fixture(scope="module")
def backed_out():
    return recordings([(QUADRICYCLE, backs_out()), (QUADRICYCLE, backs_out(-1.0))], 3, unsigned=True)


def test_a_car_that_backs_out_with_unsigned_speeds_has_no_fault(quadricycle, backed_out, tmp_path, capsys):
    write(backed_out[0], tmp_path / "out.csv")
    capsys.readouterr()
    code = main(
        [
            "diagnose",
            str(tmp_path / "out.csv"),
            "--vehicle",
            str(quadricycle),
            "--monitor",
            "condition",
            "--no-report",
            "--json",
        ]
    )
    said = capsys.readouterr().out
    assert code == 0
    warnings = json.loads(said)["findings"][0]["warnings"]
    (reversing,) = (each for each in warnings if each.startswith("the car reversed"))
    assert reversing == "the car reversed from 4.4 s to 9.0 s; its speeds have no sign"
    assert "wrong sign" not in said


def test_a_turn_out_forward_is_not_called_reversing(quadricycle, backed_out):
    finding = diagnose(backed_out[1], load(quadricycle), "condition").findings[0]
    assert finding.status is Status.HEALTHY
    assert not any("revers" in each for each in finding.warnings)


def test_where_every_turn_is_mirrored_both_causes_are_named_and_nothing_is_fault_free(quadricycle):
    speed, angle = backs_out()
    kept = slice(0, len(speed) // 4)
    (made,) = recordings([(QUADRICYCLE, (speed[kept], angle[kept]))], 3, unsigned=True)
    finding = diagnose(made, load(quadricycle), "condition").findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "the car reversed all the time, or the yaw rate has the wrong sign" in finding.headline
