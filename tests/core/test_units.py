"""Units as files write them become SI."""

import subprocess
import sys
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import InputError
from tierod.core.units import COUNT, known, scale, split_name, split_suffix, tidy


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("°", "deg"),
        ("Deg", "deg"),
        ("°/s", "deg/s"),
        ("DEG/S", "deg/s"),
        ("KM/H", "km/h"),
        ("kmh", "km/h"),
        ("m/s²", "m/s**2"),
        ("m/s^2", "m/s**2"),
        ("[m/s]", "m/s"),
        ("(m/s)", "m/s"),
        ("1/(N*m)", "1/(N*m)"),
        ("Nm", "N*m"),
        ("N m", "N*m"),
        ("U/  min", "rpm"),
        ("%", "percent"),
        ("°C", "degC"),
        ("-", ""),
        ("", ""),
        ("raw", COUNT),
        ("kPa", "kPa"),
    ],
)
def test_spellings(written, meant):
    assert tidy(written) == meant


@pytest.mark.parametrize(
    ("given_", "wanted", "value", "result"),
    [
        ("deg", "rad", 180.0, pi),
        ("km/h", "m/s", 36.0, 10.0),
        ("g", "m/s**2", 1.0, 9.80665),
        ("rpm", "rad/s", 60.0, 2.0 * pi),
        ("bar", "Pa", 2.0, 2.0e5),
        ("degC", "K", 20.0, 293.15),
        ("K", "degC", 293.15, 20.0),
        ("degF", "K", 32.0, 273.15),
        ("percent", "", 50.0, 0.5),
        ("kPa", "Pa", 1.0, 1000.0),
        ("mph", "m/s", 1.0, 0.44704),
        ("ms", "s", 5.0, 0.005),
        ("mNm", "N*m", 5.0, 0.005),
        ("Ncm", "N*m", 5.0, 0.05),
        ("kNm/rad", "N*m/rad", 5.0, 5000.0),
        ("revolution", "rad", 0.5, pi),
    ],
)
def test_conversions(given_, wanted, value, result):
    assert scale(given_, wanted)(value) == pytest.approx(result, rel=1e-12)


@given(st.sampled_from(["deg", "km/h", "rpm", "bar", "degC", "kPa", "g"]), st.floats(-1e6, 1e6))
def test_there_and_back(unit, value):
    wanted = {"deg": "rad", "km/h": "m/s", "rpm": "rad/s", "bar": "Pa", "degC": "K", "kPa": "Pa", "g": "m/s**2"}[unit]
    there = scale(unit, wanted)
    back = scale(wanted, "g_0" if unit == "g" else unit)
    assert back(there(value)) == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_values_in_the_wanted_unit_are_not_copied():
    values = np.arange(3.0)
    assert scale("m/s", "m/s")(values) is values


def test_unknown_unit():
    with pytest.raises(InputError, match="'newtonmetr' is not known.*did you mean 'newtonmeter'"):
        tidy("newtonmetr")
    assert not known("Servo motor speed")


def test_another_kind():
    with pytest.raises(InputError, match=r"'N\*m' cannot become 'rad'"):
        scale("Nm", "rad")


def test_hertz_of_what_turns_is_not_guessed():
    with pytest.raises(InputError, match="turns or radians per second; write rpm or rad/s"):
        scale("Hz", "rad/s")


def test_a_raw_count_has_no_size():
    with pytest.raises(InputError, match="give the factor in the channel map"):
        scale("count", "N*m")


def test_titles_with_units():
    assert split_name("Speed [km/h]") == ("Speed", "km/h")
    assert split_name("time (ms)") == ("time", "ms")
    assert split_name("Droop pulses (by 1 pls.)") == ("Droop pulses (by 1 pls.)", "")
    assert split_suffix("speed_m_s") == ("speed", "m/s")
    assert split_suffix("yaw_rate_deg_s") == ("yaw_rate", "deg/s")
    assert split_suffix("yaw") == ("yaw", "")


def test_si_data_does_not_cost_the_unit_library():
    code = "import sys; from tierod.core.units import scale; scale('deg', 'rad'); print('pint' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


@pytest.mark.parametrize(
    "text",
    [
        "m**9**9**9**9",
        "m^9^9^9^9",
        "(9**9)**(9**9)",
        "m**(9**9**9)",
        "m**-99",
        "m**1e9",
        "m**9.9**9",
        "m**9 **9",
        "m**(1/2)**9",
        "9**9*m",
        "((((m))))*((((m",
        "m" * 100_000,
        "m*" * 50_000 + "m",
        "(" * 50_000,
        "m/0",
        "1e999*m",
    ],
)
def test_what_would_take_for_ever_is_no_unit(text):
    with pytest.raises(InputError, match="write it as deg/s") as refused:
        tidy(text)
    assert len(str(refused.value)) < 300


@pytest.mark.parametrize(
    ("written", "wanted", "factor"),
    [
        ("V/Hz**0.5", "V/Hz**0.5", 1.0),
        ("mV/Hz**(1/2)", "V/Hz**0.5", 1e-3),
        ("kg·m²", "kg*m**2", 1.0),
        ("L/min", "m**3/s", 1.0 / 60e3),
        ("N*m*s/deg", "N*m*s/rad", 180.0 / pi),
        ("1/(N*m)", "1/(N*m)", 1.0),
        ("µm s**-1", "m/s", 1e-6),
        ("kN**2*m**2", "N**2*m**2", 1e6),
        ("m **2 / s^ 2", "m**2/s**2", 1.0),
    ],
)
def test_units_of_words_and_small_exponents_are_read(written, wanted, factor):
    assert scale(written, wanted).factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(("written", "wanted"), [("dB", ""), ("dBm", "W"), ("Np", ""), ("octave", "")])
def test_a_logarithmic_unit_is_no_scale(written, wanted):
    with pytest.raises(InputError, match=f"'{written}' is logarithmic, and no factor converts it to '{wanted}'"):
        scale(written, wanted)


def test_units_at_which_the_library_fails_are_refused():
    with pytest.raises(InputError, match=r"'dB\*m' has no fixed size in 'm'"):
        scale("dB*m", "m")


def test_a_title_of_any_length_is_split_at_once():
    title = "a" + " " * 200_000 + "b ["
    assert split_name(title) == (title, "")
