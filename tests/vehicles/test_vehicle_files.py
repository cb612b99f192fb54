"""Vehicle files: what they say in SI, a slip named with its line, and values written where they stand."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import QUANTITIES, load, shipped
from tierod.vehicles.vehicle import SHIPPED
from tierod.vehicles.writer import Change, changed, with_thresholds

WHOLE = """\
name = "mine"
description = "My car"
source = "a weighbridge"
good_for = ["tests"]
not_good_for = ["anything else"]
torque_unit = "N*m"

[parameters.mass]
value = 1.6
unit = "tonne"
standard_deviation = 0.1
source = "weighbridge"

[parameters.trail]
value = 50
unit = "mm"
source = "assumed: half and half"
"""


@pytest.fixture
def write(tmp_path):
    def write(text: str) -> Path:
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_vehicle_loads(name):
    vehicle = load(name)
    assert vehicle.name == name
    assert set(vehicle.parameters) <= set(QUANTITIES)
    assert vehicle.good_for
    assert vehicle.not_good_for
    for parameter in vehicle.parameters.values():
        assert parameter.source


def test_converts_value_and_spread_to_si(write):
    vehicle = load(write(WHOLE))
    assert vehicle["mass"] == pytest.approx(1600.0)
    assert vehicle.parameters["mass"].standard_deviation == pytest.approx(100.0)
    assert vehicle["trail"] == pytest.approx(0.05)
    assert vehicle.parameters["trail"].standard_deviation is None
    assert vehicle.parameters["trail"].assumed
    assert not vehicle.parameters["mass"].assumed
    assert vehicle.rows()[0][:3] == ("mass", pytest.approx(1600.0), "kg")


def test_names_what_a_dataclass_needs_and_the_file_lacks(write):
    @dataclass(frozen=True)
    class Demanding:
        mass: float
        yaw_inertia: float
        motor_ratio: float

    with pytest.raises(ParameterError, match=r"lacks yaw_inertia, motor_ratio\. Add \[parameters.*mine\.toml"):
        load(write(WHOLE)).parameters_for(Demanding)


def test_a_shipped_file_is_not_for_editing():
    with pytest.raises(ParameterError, match=r"tierod vehicles rav4 --toml > car.toml.*--vehicle car.toml") as caught:
        load("rav4")["nominal_friction"]
    assert "rav4.toml" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("[parameters.mass]", "[parameters.mas]", 8, "did you mean 'mass'"),
        ('unit = "tonne"', 'unt = "tonne"', 10, "'unt' is not known here; did you mean 'unit'"),
        ("value = 1.6\n", "", 8, "'value' is missing; add it"),
        ("value = 1.6", 'value = "1.6 t"', 9, "has to be a number without unit"),
        ("value = 1.6", "value = nan", 9, "finite number"),
        ("standard_deviation = 0.1", "standard_deviation = -0.1", 11, "has to be at least 0"),
        ('"tonne"', '"metre"', 10, "cannot become 'kg'"),
        ('"tonne"', '"kg"', 9, "lies between 200 and 60000 kg"),
        ('torque_unit = "N*m"', 'torque_unitt = "N*m"', 6, "did you mean 'torque_unit'?"),
        ('good_for = ["tests"]', "good_for = []", 4, "is empty; give at least one use"),
        ('name = "mine"', 'name = "mine', 1, "not valid TOML"),
        ("[parameters.mass]", '[channels]\nmap = "no.toml"\n\n[parameters.mass]', 9, "no.toml is not there"),
        ("[parameters.mass]", '[channels]\ndbcs = "no.toml"\n\n[parameters.mass]', 9, "did you mean 'dbc'"),
    ],
)
def test_a_slip_is_named_with_its_line(write, old, new, line, message):
    assert old in WHOLE
    with pytest.raises(ParameterError) as caught:
        load(write(WHOLE.replace(old, new, 1)))
    assert message in str(caught.value)
    assert "mine.toml" in str(caught.value)
    assert f"line {line}" in str(caught.value)


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


THRESHOLDS = {"source": "an hour of healthy driving", "gap": 2.5, "fast": {"yaw_rate": 1.0, "yaw_rate + angle": 2.0}}


def test_older_thresholds_are_replaced_and_those_of_others_stay():
    first = with_thresholds(with_thresholds(TEXT, "condition", THRESHOLDS), "rules", {"r1": 1.0})
    again = with_thresholds(first, "condition", THRESHOLDS | {"gap": 3.0})
    assert again.count("[thresholds.condition]") == 1
    assert tomllib.loads(again)["thresholds"] == {"rules": {"r1": 1.0}, "condition": THRESHOLDS | {"gap": 3.0}}
    windows = with_thresholds(first.replace("\n", "\r\n"), "condition", THRESHOLDS)
    assert "\n" not in windows.replace("\r\n", "")
