import tomllib

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod.vehicles.writer import Change, changed, with_thresholds

TEXT = (SHIPPED / "column-bench.toml").read_text(encoding="utf-8")
FOUND = Change(0.0012345678901, 1.23456e-5, 'identified from "bench.mf4"')


def test_only_the_changed_lines_change():
    after = changed(TEXT, {"motor_damping": FOUND}).split("\n")
    differing = [(a, b) for a, b in zip(TEXT.split("\n"), after, strict=True) if a != b]
    assert [new for _, new in differing] == [
        "value = 0.0012345679",
        "standard_deviation = 1.23e-05",
        'source = "identified from \\"bench.mf4\\""',
    ]


def test_comments_order_and_units_stay(tmp_path):
    text = TEXT.replace('value = 1.448563969e-4\nunit = "kg*m**2"', 'value = 1.448563969  # weighed\nunit = "kg*cm**2"')
    after = changed(text, {"motor_inertia": Change(1.5e-4, 2e-6, "swung")})
    assert "value = 1.5  # weighed" in after
    path = tmp_path / "car.toml"
    path.write_text(after, encoding="utf-8")
    assert load(path)["motor_inertia"] == pytest.approx(1.5e-4)
    assert load(path).parameters["motor_inertia"].standard_deviation == pytest.approx(2e-6)


def test_what_the_file_lacks_is_added():
    short = TEXT[: TEXT.index("[parameters.motor_friction]")]
    after = tomllib.loads(changed(short, {"motor_friction": FOUND}))["parameters"]
    assert after["motor_friction"]["unit"] == "N*m"
    assert list(after)[:-1] == list(tomllib.loads(short)["parameters"])


def test_a_missing_deviation_is_added_beside_the_value():
    text = TEXT.replace('value = 0.1\nunit = "N*m"\nstandard_deviation = 0.02\n', 'value = 0.1\nunit = "N*m"\n')
    entry = tomllib.loads(changed(text, {"motor_friction": FOUND}))["parameters"]["motor_friction"]
    assert entry["standard_deviation"] == pytest.approx(1.23e-5)


def test_a_parameter_written_in_line_is_refused_with_the_cure():
    entry = '[parameters]\nmotor_friction = { value = 0.1, unit = "N*m", source = "a note" }\n'
    with pytest.raises(ParameterError, match=r"\[parameters.motor_friction\]"):
        changed(entry, {"motor_friction": FOUND})


def test_line_ends_of_windows_stay():
    after = changed(TEXT.replace("\n", "\r\n"), {"motor_damping": FOUND})
    assert after.replace("\r\n", "\n") == changed(TEXT, {"motor_damping": FOUND})
    assert after.count("\r\n") == after.count("\n")


THRESHOLDS = {"source": "an hour of healthy driving", "gap": 2.5, "fast": {"yaw_rate": 1.0, "yaw_rate + angle": 2.0}}


def test_thresholds_are_added_and_read_back(tmp_path):
    path = tmp_path / "car.toml"
    path.write_text(with_thresholds(TEXT, "condition", THRESHOLDS), encoding="utf-8")
    assert path.read_text(encoding="utf-8").startswith(TEXT.rstrip())
    car = load(path)
    assert car.thresholds == {"condition": THRESHOLDS}
    assert car.parameters.keys() == load("column-bench").parameters.keys()


def test_older_thresholds_are_replaced_and_those_of_others_stay():
    first = with_thresholds(with_thresholds(TEXT, "condition", THRESHOLDS), "rules", {"r1": 1.0})
    again = with_thresholds(first, "condition", THRESHOLDS | {"gap": 3.0})
    assert again.count("[thresholds.condition]") == 1
    assert tomllib.loads(again)["thresholds"] == {"rules": {"r1": 1.0}, "condition": THRESHOLDS | {"gap": 3.0}}
    windows = with_thresholds(first.replace("\n", "\r\n"), "condition", THRESHOLDS)
    assert "\n" not in windows.replace("\r\n", "")


def test_older_thresholds_in_line_are_refused_with_the_cure():
    text = TEXT + "\n[thresholds]\ncondition = {gap = 1.0}\n"
    with pytest.raises(ParameterError, match=r"\[thresholds.condition\]"):
        with_thresholds(text, "condition", THRESHOLDS)


def test_thresholds_that_are_no_numbers_are_refused_with_their_line(tmp_path):
    path = tmp_path / "car.toml"
    path.write_text(TEXT + "\n[thresholds.condition]\ngap = [1, 2]\n", encoding="utf-8")
    with pytest.raises(ParameterError, match=r"line \d+.*thresholds.condition"):
        load(path)
