"""Small slow cars with sensors of the motion alone: parking, walking pace and tight turns are no faults."""

import json

import pytest

from monitors.condition.small_car import QUADRICYCLE, SCALE_CAR, backs_out, course, recordings, vehicle_of
from tierod.cli import main
from tierod.core.statuses import Status
from tierod.io.writers import write
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import GAIN, OFFSET, Injected


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
    assert "the car reversed all the time, or the yaw rate has the wrong sign" in finding.cause


@pytest.mark.parametrize("reverse", [False, True])
def test_tight_turns_at_walking_pace_are_no_faults(reverse):
    cars = [car for car in (QUADRICYCLE, SCALE_CAR) for _ in range(3)]
    courses = [course(5000 + k, car.front + car.rear, 45.0, reverse=reverse) for k, car in enumerate(cars)]
    made = recordings(list(zip(cars, courses, strict=True)), 5000, unsigned=reverse)
    for car, each in zip(cars, made, strict=True):
        finding = diagnose(each, vehicle_of(car), "condition").findings[0]
        assert finding.status not in (Status.FAULT, Status.SUSPECT), finding.headline


@pytest.mark.parametrize(("sensor", "kind", "size"), [("yaw_rate", GAIN, 1.6), ("wheel_speed_front_left", OFFSET, 1.5)])
@pytest.mark.parametrize("car", [QUADRICYCLE, SCALE_CAR])
def test_a_fault_of_a_slow_car_is_still_named(car, sensor, kind, size):
    (made,) = recordings([(car, course(5010, car.front + car.rear, 30.0))], 5010)
    fault = Injected(sensor, kind, size, 15.0, 25.0).fault
    found = diagnose(injected(made, [fault]), vehicle_of(car), "condition")
    assert [each.name for each in found.elements if each.status is Status.FAULT] == [sensor]
