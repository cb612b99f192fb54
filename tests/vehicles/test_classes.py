"""Values as users give them, of a class or a similar car, and how far each may be off."""

from __future__ import annotations

import dataclasses

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import QUANTITIES, VEHICLES, load
from tierod.vehicles.classes import Known, bound_distance, class_of, classes, in_words, moved, typical, with_spread
from tierod.vehicles.writer import begun, known_from


@pytest.mark.parametrize("kind", classes())
def test_typical_values_are_plausible_and_have_a_spread_and_a_source(kind):
    for name, found in typical(kind).items():
        low, high = QUANTITIES[name].plausible
        assert low <= found.value <= high, name
        assert found.unit == QUANTITIES[name].unit
        assert found.standard_deviation is not None
        assert found.standard_deviation >= 0.0
        assert found.assumed
        assert kind in found.source


def test_given_values_replace_the_class_and_their_spread_reaches_what_follows():
    sharp = typical("midsize", {"mass": Known(1480.0, 1.0), "wheelbase": Known(2.68, 0.001)})
    loose = typical("midsize", {"mass": Known(1480.0, 300.0), "wheelbase": Known(2.68, 0.001)})
    assert sharp["mass"].value == 1480.0
    assert sharp["mass"].standard_deviation == 1.0
    assert sharp["front_distance"].value + sharp["rear_distance"].value == pytest.approx(2.68)
    # The share of the weight, 0.58 +- 0.035, decides the distances.
    assert sharp["rear_distance"].standard_deviation == pytest.approx(0.035 * 2.68, rel=0.01)
    assert loose["yaw_inertia"].standard_deviation > 1.5 * sharp["yaw_inertia"].standard_deviation


def test_the_class_of_an_own_car_follows_from_mass_wheelbase_and_tyres(tmp_path):
    text = VEHICLES["midsize-eps"].read_text()
    own = tmp_path / "own.toml"
    own.write_text(text.replace("1600.0", "2400.0").replace("1.14", "1.5").replace("1.69", "1.9"))
    assert class_of(load(own)) == "van"


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


@pytest.mark.parametrize(
    ("text", "value", "spread"),
    [
        ("mass=1480", 1480.0, None),
        ("mass=1.48 t", 1480.0, None),
        ("mass=1480+-20", 1480.0, 20.0),
        ("mass=1480 ± 20 kg", 1480.0, 20.0),
        ("mass=1.48 +- 0.02 t", 1480.0, 20.0),
        ("mass=1.48 t +- 3 %", 1480.0, 44.4),
        ("steering_ratio=1/16", 0.0625, None),
        ("yaw_rate_offset=-0.2 deg/s", -0.00349066, None),
    ],
)
def test_reads_value_unit_and_spread(text, value, spread):
    (found,) = known_from([text]).values()
    assert found.value == pytest.approx(value, rel=1e-5)
    assert found.standard_deviation == (None if spread is None else pytest.approx(spread))


@pytest.mark.parametrize(
    ("texts", "sentence"),
    [
        (["mas=1480"], "did you mean 'mass'"),
        (["mass=heavy"], "is not a number"),
        (["steering_ratio=1:15.5"], "is not a number; write a ratio as steering_ratio=1/15.5$"),
        (["mass=1500,5"], "is not a number; write a decimal point, .* thousands: mass=1500.5$"),
        (["mass=1480 +- 0,5 t"], "write a decimal point, .*: mass=1480 .- 0.5 t$"),
        (["mass=1.500,5"], "no mark between thousands: mass=1480.5$"),
        (["mass=1480 m"], "cannot become 'kg'"),
        (["mass=1.48"], "between 200 and 60000 kg"),
        (["mass=1480+--20"], "negative spread"),
        (["mass=1480", "mass=1500"], "given twice"),
        (["steering_ratio=16"], "steering_ratio=1/16"),
        (["front_share=58"], "front_share=0.58"),
        (["front_share=0.58", "front_distance=1.1"], "give one of them"),
        (["wheelbase=2.6", "front_distance=1.1", "rear_distance=1.7"], "leave one of them out"),
        (["nominal_friction=4 count"], "cannot become|not in count|raw count"),
        (["motor_pole_pairs=3.5"], "no whole number; write for example motor_pole_pairs=4$"),
    ],
)
def test_says_what_is_wrong(texts, sentence):
    with pytest.raises(ParameterError, match=sentence):
        known_from(texts)


def car(**deviations):
    vehicle = load("midsize-eps")
    parameters = {
        name: dataclasses.replace(each, standard_deviation=deviations.get(name))
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters)


def test_a_small_spread_moves_by_differences_and_nothing_else_moves():
    vehicle = car(mass=160.0, rear_distance=0.1)
    other = moved(vehicle, {"mass": -2.0})
    assert other["mass"] == pytest.approx(1280.0)
    assert other["rear_distance"] == vehicle["rear_distance"]


def with_wheelbase(**deviations):
    _, parameters = begun({"mass": Known(1500.0), "wheelbase": Known(2.7)}, "midsize")
    known = {each.name: each for each in parameters}
    for name, deviation in deviations.items():
        known[name] = dataclasses.replace(known[name], standard_deviation=deviation)
    return dataclasses.replace(load("midsize-eps"), parameters=known)


@pytest.mark.parametrize("by", [-2.0, 1.0])
def test_a_wheelbase_that_is_known_binds_the_distances_of_the_axles(by):
    vehicle = with_wheelbase()
    assert bound_distance(vehicle)
    other = moved(vehicle, {"rear_distance": by})
    assert other["rear_distance"] - vehicle["rear_distance"] == pytest.approx(
        by * vehicle.parameters["rear_distance"].standard_deviation
    )
    assert other["rear_distance"] + other["front_distance"] == pytest.approx(2.7)


def test_a_file_without_deviations_takes_those_of_its_class_and_an_explicit_zero_stays():
    vehicle, filled = with_spread(car(rear_distance=0.0, trail=0.001))
    assert vehicle.parameters["mass"].standard_deviation == pytest.approx(0.05 * 1600.0)
    assert vehicle.parameters["rear_distance"].standard_deviation == 0.0
    assert vehicle.parameters["trail"].standard_deviation == 0.001
    assert "mass" in filled
    assert not {"rear_distance", "trail", "fault_friction"} & set(filled)
    sentence = in_words(vehicle, filled)
    assert "class 'midsize'" in sentence
    assert "standard_deviation in the vehicle file" in sentence
    assert in_words(vehicle, ()) == ""
