"""A vehicle file of an own car: what is given, what is taken from a similar car, what is typical of the class."""

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import load
from tierod.vehicles.classes import Known, classes
from tierod.vehicles.draft import begun, known_from


def parameters(texts, of=None, like=None):
    kind, found = begun(known_from(texts), of, like and load(like))
    return kind, {each.name: each for each in found}


@pytest.mark.parametrize("kind", classes())
def test_every_value_has_a_spread_and_a_source_that_says_assumed(kind):
    _, found = parameters(["mass=1480" if kind != "quadricycle" else "mass=480"], kind)
    assert found["mass"].standard_deviation == pytest.approx(0.05 * found["mass"].value)
    for name, each in found.items():
        assert each.standard_deviation is not None
        assert each.assumed == (name != "mass")


def test_a_similar_car_is_scaled_to_the_given_mass_and_wheelbase():
    kind, found = parameters(["mass=1480", "wheelbase=2.68"], like="midsize-eps")
    like = load("midsize-eps")
    assert kind == "midsize"
    assert found["front_distance"].value + found["rear_distance"].value == pytest.approx(2.68)
    assert found["front_distance"].value / 2.68 == pytest.approx(1.14 / 2.83)
    assert found["front_cornering_stiffness"].value == pytest.approx(like["front_cornering_stiffness"] * 1480 / 1600)
    assert found["torsion_bar_stiffness"].value == like["torsion_bar_stiffness"]
    assert "midsize-eps" in found["torsion_bar_stiffness"].source


def test_a_similar_car_is_no_better_known_than_its_class():
    _, found = parameters([], like="midsize-eps")
    like = load("midsize-eps").parameters
    assert found["motor_ratio"].standard_deviation > 1.0 > like["motor_ratio"].standard_deviation
    for name, each in like.items():
        assert found[name].standard_deviation >= (each.standard_deviation or 0.0)


def test_torques_in_counts_are_not_taken_from_another_car():
    _, found = parameters([], like="rav4")
    assert found["nominal_friction"].unit == "N*m"
    assert "suv" in found["nominal_friction"].source


def test_a_motor_is_written_only_where_it_is_given():
    _, without = parameters([], "small")
    _, given = parameters(["motor_flux=0.0079", "motor_pole_pairs=4+-0"], "small")
    assert "motor_flux" not in without
    assert given["motor_flux"].standard_deviation == pytest.approx(0.05 * 0.0079)
    assert given["motor_pole_pairs"].standard_deviation == 0.0


def test_a_value_without_a_class_gets_a_wide_spread():
    _, found = begun({"rack_stiffness": Known(100.0)}, "small", None)
    assert {each.name: each for each in found}["rack_stiffness"].standard_deviation == pytest.approx(30.0)


def test_neither_class_nor_car_is_an_error_that_lists_the_classes():
    with pytest.raises(ParameterError, match="quadricycle, small, midsize"):
        begun({})
