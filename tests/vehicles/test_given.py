"""Values as users write them: units, spreads, ratios, and clear errors."""

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles.draft import known_from


@pytest.mark.parametrize(
    ("text", "value", "spread"),
    [
        ("mass=1480", 1480.0, None),
        ("mass=1480 kg", 1480.0, None),
        ("mass=1.48 t", 1480.0, None),
        ("mass=1.48t", 1480.0, None),
        ("mass=1480+-20", 1480.0, 20.0),
        ("mass=1480 ± 20 kg", 1480.0, 20.0),
        ("mass=1.48 t +- 20 kg", 1480.0, 20.0),
        ("mass=1.48 +- 0.02 t", 1480.0, 20.0),
        ("mass=1.48 t +- 3 %", 1480.0, 44.4),
        ("steering_ratio=1/16", 0.0625, None),
        ("wheelbase=2680 mm", 2.68, None),
        ("yaw_rate_offset=-0.2 deg/s", -0.00349066, None),
        ("yaw_inertia=2.4e3+-10%", 2400.0, 240.0),
        ("front_cornering_stiffness=100 kN/rad", 100e3, None),
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
        (["mass"], "write NAME=VALUE"),
        (["mass=heavy"], "is not a number"),
        (["mass="], "is not a number"),
        (["steering_ratio=1:15.5"], "is not a number; write a ratio as steering_ratio=1/15.5$"),
        (["mass=1500,5"], "is not a number; write a decimal point, .* thousands: mass=1500.5$"),
        (["wheelbase=2,68 m"], "write a decimal point, .*: wheelbase=2.68 m$"),
        (["mass=1480 +- 0,5 t"], "write a decimal point, .*: mass=1480 .- 0.5 t$"),
        (["mass=1,500"], "no mark between thousands: mass=1480.5$"),
        (["mass=1.500,5"], "no mark between thousands: mass=1480.5$"),
        (["mass=1500;5"], "is not a number; write for example"),
        (["mass=1480 m"], "cannot become 'kg'"),
        (["mass=1480 kgg"], "not known"),
        (["mass=1.48"], "between 200 and 60000 kg"),
        (["mass=1480+--20"], "negative spread"),
        (["mass=1480", "mass=1500"], "given twice"),
        (["steering_ratio=16"], "steering_ratio=1/16"),
        (["steering_ratio=1/0"], "divides by zero"),
        (["front_share=58"], "front_share=0.58"),
        (["front_share=0.58", "front_distance=1.1"], "give one of them"),
        (["wheelbase=2.6", "front_distance=1.1", "rear_distance=1.7"], "leave one of them out"),
        (["wheelbase=2.6", "front_distance=2.8"], "leave one of them out"),
        (["mass=1e999"], "between 200"),
        (["mass=1480+-1e999"], "not a finite number"),
        (["nominal_friction=4 count"], "cannot become|not in count|raw count"),
        (["motor_pole_pairs=3.5"], "no whole number; write for example motor_pole_pairs=4$"),
        (["motor_pole_pairs=3+-1"], "no whole number; write for example motor_pole_pairs=3$"),
    ],
)
def test_says_what_is_wrong(texts, sentence):
    with pytest.raises(ParameterError, match=sentence):
        known_from(texts)
