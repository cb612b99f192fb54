import pytest

from tierod.core.block import units
from tierod.core.signals import SIGNALS
from tierod.proving_ground.steering.linkage import SteeringSignals

FIELDS = list(zip(SteeringSignals._fields, units(SteeringSignals), strict=True))


@pytest.mark.parametrize(("name", "unit"), [field for field in FIELDS if not field[0].startswith("truth_")])
def test_signals_have_canonical_names_and_units(name, unit):
    assert SIGNALS[name].unit == unit
