"""Signals and units as recordings name them find the catalogue's signal and become SI."""

from __future__ import annotations

import math
import re
from math import pi

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.signals import SIGNALS, match, plain, residue_of
from tierod.core.units import COUNT, known, scale, split_name, split_suffix, tidy


def test_every_signal_is_well_formed():
    for name, found in SIGNALS.items():
        assert found.name == name
        assert re.fullmatch(r"[a-z][a-z0-9_]*", name)
        assert found.meaning.endswith("."), name
        assert found.group, name
        assert found.plausible[0] < found.plausible[1], name
        assert tidy(found.unit) == found.unit, f"the unit of {name} is not written as pint writes it"
        assert scale(found.unit, found.unit).factor == 1.0, name


def test_no_alias_means_two_signals():
    owners: dict[str, set[str]] = {}
    for found in SIGNALS.values():
        for alias in (found.name, *found.aliases):
            owners.setdefault(plain(alias), set()).add(found.name)
    assert {alias: names for alias, names in owners.items() if len(names) > 1} == {}


@pytest.mark.parametrize(
    ("recorded", "meant"),
    [
        ("SW_pos_obd", "steering_wheel_angle"),
        ("LatAcc_obd", "lateral_acceleration"),
        ("STEER_TORQUE_SENSOR.STEER_TORQUE_DRIVER", "driver_torque"),
        ("RecStr.SlessIAlpha", "motor_current_alpha"),
        ("yawRate", "yaw_rate"),
    ],
)
def test_names_of_real_recordings_find_their_signal(recorded, meant):
    found = match(recorded)
    assert found is not None
    assert found.name == meant


@pytest.mark.parametrize("recorded", ["id", "can_id", "forward", "INP", ""])
def test_other_names_find_none(recorded):
    assert match(recorded) is None


@pytest.mark.parametrize(
    ("recorded", "unit", "meant"),
    [
        ("Engine.Speed", "rpm", None),
        ("Engine.Speed", "", None),
        ("Wiper::v", "V", None),
        ("Seat/roll", "mm", None),
        ("Vehicle.v", "km/h", "vehicle_speed"),
        ("Imu/yaw", "deg/s", "yaw_rate"),
        ("speed", "", "vehicle_speed"),
        ("ESP.YawRate", "", "yaw_rate"),
        ("Imu.ay", "", "lateral_acceleration"),
    ],
)
def test_a_general_word_behind_a_qualifier_needs_a_unit_that_fits(recorded, unit, meant):
    found = match(recorded, unit)
    assert (found and found.name) == meant


WHEEL = SIGNALS["steering_wheel_angle"].plausible[1]


def test_single_precision_of_a_plausible_reading_is_a_residue_and_a_step_of_a_sensor_is_none():
    for reading in np.linspace(-WHEEL, WHEEL, 101).tolist():
        assert abs(float(np.float32(reading)) - reading) < residue_of("steering_wheel_angle")
    assert residue_of("steering_wheel_angle") < 0.01 * math.radians(0.1)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("°", "deg"),
        ("°/s", "deg/s"),
        ("KM/H", "km/h"),
        ("m/s^2", "m/s**2"),
        ("[m/s]", "m/s"),
        ("1/(N*m)", "1/(N*m)"),
        ("Nm", "N*m"),
        ("U/  min", "rpm"),
        ("%", "percent"),
        ("°C", "degC"),
        ("", ""),
        ("raw", COUNT),
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
        ("degF", "K", 32.0, 273.15),
        ("percent", "", 50.0, 0.5),
        ("Ncm", "N*m", 5.0, 0.05),
        ("revolution", "rad", 0.5, pi),
    ],
)
def test_conversions(given_, wanted, value, result):
    assert scale(given_, wanted)(value) == pytest.approx(result, rel=1e-12)


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


@pytest.mark.parametrize(
    "text", ["m**9**9**9**9", "(9**9)**(9**9)", "m**-99", "m**(1/2)**9", "m" * 100_000, "(" * 50_000, "m/0"]
)
def test_what_would_take_for_ever_is_no_unit(text):
    with pytest.raises(InputError, match="write it as deg/s") as refused:
        tidy(text)
    assert len(str(refused.value)) < 300


@pytest.mark.parametrize(
    ("written", "wanted", "factor"),
    [
        ("mV/Hz**(1/2)", "V/Hz**0.5", 1e-3),
        ("kg·m²", "kg*m**2", 1.0),
        ("N*m*s/deg", "N*m*s/rad", 180.0 / pi),
        ("µm s**-1", "m/s", 1e-6),
        ("m **2 / s^ 2", "m**2/s**2", 1.0),
    ],
)
def test_units_of_words_and_small_exponents_are_read(written, wanted, factor):
    assert scale(written, wanted).factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(("written", "wanted"), [("dB", ""), ("dBm", "W")])
def test_a_logarithmic_unit_is_no_scale(written, wanted):
    with pytest.raises(InputError, match=f"'{written}' is logarithmic, and no factor converts it to '{wanted}'"):
        scale(written, wanted)
