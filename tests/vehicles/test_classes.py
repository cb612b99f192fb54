"""The table of classes: typical values that a vehicle file accepts, spreads that combine, classes of known cars."""

from __future__ import annotations

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import VEHICLES, load
from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.classes import Known, class_of, classes, rules, typical, typical_spread


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


def test_one_distance_and_the_wheelbase_give_the_other():
    found = typical("small", {"wheelbase": Known(2.5), "front_distance": Known(1.1, 0.01)})
    assert found["rear_distance"].value == pytest.approx(1.4)
    assert found["front_distance"].standard_deviation == 0.01


@pytest.mark.parametrize(
    ("name", "kind"), [("midsize-eps", "midsize"), ("ferrari-250lm", "race-car"), ("smartload", "quadricycle")]
)
def test_the_class_of_a_shipped_car(name, kind):
    assert class_of(load(name)) == kind


def test_the_class_of_an_own_car_follows_from_mass_wheelbase_and_tyres(tmp_path):
    text = VEHICLES["midsize-eps"].read_text()
    own = tmp_path / "own.toml"
    own.write_text(text.replace("1600.0", "2400.0").replace("1.14", "1.5").replace("1.69", "1.9"))
    assert class_of(load(own)) == "van"


def test_spreads_of_values_given_without_one():
    assert typical_spread("mass", 1480.0, "midsize") == pytest.approx(0.05 * 1480.0)
    assert typical_spread("yaw_rate_offset", 0.0, "van") == 0.005
    assert typical_spread("stiffness_wander", 1.0, "van") is None
    with pytest.raises(ParameterError, match="midsize"):
        typical_spread("mass", 1480.0, "midsise")


def test_rules_refer_to_what_there_is():
    for rule in rules().values():
        assert set(rule.powers) <= {*rules(), "rear_share"}
