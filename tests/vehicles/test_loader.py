import dataclasses
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import ParameterError
from tierod.vehicles import QUANTITIES, load, shipped

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


@dataclass(frozen=True)
class Wanted:
    mass: float
    trail: float
    motor_ratio: float = 20.0


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_vehicle_loads(name):
    vehicle = load(name)
    assert vehicle.name == name
    assert set(vehicle.parameters) <= set(QUANTITIES)
    assert vehicle.good_for
    assert vehicle.not_good_for
    for parameter in vehicle.parameters.values():
        assert parameter.source


def test_the_midsize_car_has_the_values_of_the_documentation():
    vehicle = load("midsize-eps")
    expected = {
        "mass": 1600.0,
        "yaw_inertia": 2800.0,
        "front_distance": 1.14,
        "rear_distance": 1.69,
        "trail": 0.050,
        "front_cornering_stiffness": 110e3,
        "rear_cornering_stiffness": 130e3,
        "steering_ratio": 1 / 15.5,
        "column_inertia": 0.10,
        "column_damping": 0.8,
        "motor_ratio": 20.0,
        "motor_torque_constant": 0.05,
        "maximum_assist_torque": 60.0,
        "nominal_friction": 4.0,
        "fault_friction": 7.5,
    }
    assert {name: vehicle[name] for name in expected} == pytest.approx(expected, rel=1e-12)
    levels = [vehicle[f"{level}_friction"] for level in ("nominal", "rising", "fault", "noticeable")]
    assert levels == sorted(levels)


def test_the_rav4_does_not_pretend_to_be_calibrated():
    vehicle = load("rav4")
    assert not vehicle.calibrated
    assert "nominal_friction" not in vehicle
    assert any("N·m" in warning for warning in vehicle.not_good_for)


def test_the_rav4_brings_its_database_and_its_channel_map():
    vehicle = load("rav4")
    assert vehicle.database.name == "rav4.dbc"
    assert vehicle.channel_map.name == "rav4.channels.toml"
    assert "rav4.channels" not in shipped()


def test_converts_value_and_spread_to_si(write):
    vehicle = load(write(WHOLE))
    assert vehicle["mass"] == pytest.approx(1600.0)
    assert vehicle.parameters["mass"].standard_deviation == pytest.approx(100.0)
    assert vehicle["trail"] == pytest.approx(0.05)
    assert vehicle.parameters["trail"].standard_deviation is None
    assert vehicle.parameters["trail"].assumed
    assert not vehicle.parameters["mass"].assumed
    assert vehicle.rows()[0][:3] == ("mass", pytest.approx(1600.0), "kg")


def test_fills_a_dataclass_by_the_names_of_its_fields(write):
    wanted = load(write(WHOLE)).parameters_for(Wanted)
    assert dataclasses.astuple(wanted) == pytest.approx((1600.0, 0.05, 20.0))


def test_a_torque_in_counts_stays_in_counts(write):
    text = (
        WHOLE.replace('"N*m"', '"count"')
        + '\n[parameters.nominal_friction]\nvalue = 500\nunit = "count"\nsource = "x"\n'
    )
    vehicle = load(write(text))
    assert vehicle["nominal_friction"] == 500.0
    assert vehicle.parameters["nominal_friction"].unit == "count"


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


def test_an_absent_parameter_names_the_nearest(write):
    with pytest.raises(ParameterError, match="did you mean 'trail'"):
        load(write(WHOLE))["trial"]


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("[parameters.mass]", "[parameters.mas]", 8, "did you mean 'mass'"),
        ('unit = "tonne"', 'unt = "tonne"', 10, "'unt' is not known here; did you mean 'unit'"),
        ("value = 1.6\n", "", 8, "'value' is missing; add it"),
        ("value = 1.6", 'value = "1.6 t"', 9, "has to be a number without unit"),
        ("value = 1.6", "value = nan", 9, "finite number"),
        ("value = 1.6", "value = true", 9, "has to be a number"),
        ("standard_deviation = 0.1", "standard_deviation = -0.1", 11, "has to be at least 0"),
        ('"tonne"', '"metre"', 10, "cannot become 'kg'"),
        ('"tonne"', '"toonne"', 10, "is not known"),
        ('"tonne"', '"kg"', 9, "lies between 200 and 60000 kg"),
        ('torque_unit = "N*m"', 'torque_unit = "Nm"', 6, "which is not among N*m, count"),
        ('torque_unit = "N*m"', 'torque_unitt = "N*m"', 6, "did you mean 'torque_unit'?"),
        ('good_for = ["tests"]', "good_for = []", 4, "is empty; give at least one use"),
        ('source = "weighbridge"', 'source = " "', 12, "a text that is not empty"),
        ('name = "mine"', 'name = "mine', 1, "not valid TOML"),
        ("[parameters.mass]", '[channels]\nmap = "no.toml"\n\n[parameters.mass]', 9, "no.toml is not there"),
        ("[parameters.mass]", '[channels]\ndbcs = "no.toml"\n\n[parameters.mass]', 9, "did you mean 'dbc'"),
        (WHOLE[WHOLE.index("[parameters.mass]") :], "parameters = 3", 8, "has to be a table"),
    ],
)
def test_a_slip_is_named_with_its_line(write, old, new, line, message):
    assert old in WHOLE
    with pytest.raises(ParameterError) as caught:
        load(write(WHOLE.replace(old, new, 1)))
    assert message in str(caught.value)
    assert "mine.toml" in str(caught.value)
    assert f"line {line}" in str(caught.value)


VALUES = st.sampled_from(
    ["3", "-1.5", "true", "[]", "[1]", '""', '"kg"', '"N*m"', "{}", "{ value = 1 }", "nan", "1979-05-27", ""]
)


@given(
    line=st.integers(0, len(WHOLE.splitlines()) - 1), value=VALUES, key=st.sampled_from(["name", "mass", "unit", "x.y"])
)
def test_any_one_wrong_line_loads_or_is_explained(tmp_path_factory, line, value, key):
    lines = WHOLE.splitlines()
    before, equals, _ = lines[line].partition("=")
    lines[line] = f"{before}={value}" if equals else f"[{key}]"
    path = tmp_path_factory.mktemp("fuzz") / "car.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    said = "car.toml"
    try:
        load(path)
    except ParameterError as error:
        said = str(error)
    assert "car.toml" in said


def test_an_unknown_name_names_the_nearest():
    with pytest.raises(ParameterError, match="did you mean 'midsize-eps'"):
        load("midsise-eps")


def test_an_absent_file_is_named(tmp_path):
    with pytest.raises(ParameterError, match="there is no vehicle file .*car.toml; 'tierod vehicles' lists"):
        load(tmp_path / "car.toml")


def test_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "car.toml"
    path.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(ParameterError, match="not UTF-8"):
        load(path)


def test_a_folder_is_no_vehicle(tmp_path):
    with pytest.raises(ParameterError, match="there is no vehicle file"):
        load(tmp_path)


def test_a_value_without_a_unit_is_reported_without_gaps(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(WHOLE + '\n[parameters.motor_ratio]\nvalue = -18.0\nunit = ""\nsource = "counted"\n')
    with pytest.raises(
        ParameterError, match=r"motor_ratio is -18, but a road vehicle lies between 0\.5 and 200; check"
    ):
        load(path)
