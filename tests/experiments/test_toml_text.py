"""Tables written as TOML are read as they were."""

import math
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod_lab.campaign.scenarios import toml_text

TEXTS = st.text(st.characters(exclude_categories=("Cs",)))
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | TEXTS,
    lambda inner: st.lists(inner) | st.dictionaries(TEXTS, inner),
    max_leaves=12,
)


@given(st.dictionaries(TEXTS, VALUES))
def test_what_is_written_is_read_again(content):
    assert tomllib.loads(toml_text(content)) == content


def test_a_scenario_reads_well():
    text = toml_text({"car": {"name": "midsize", "parameters": {"chassis.mass": 1500.0}}, "seconds": 60})
    assert text == 'car = { name = "midsize", parameters = { "chassis.mass" = 1500.0 } }\nseconds = 60\n'
    assert math.isnan(tomllib.loads(toml_text({"a": math.nan}))["a"])


def test_what_toml_does_not_know_is_refused():
    with pytest.raises(TypeError, match="cannot be written as TOML"):
        toml_text({"a": None})
