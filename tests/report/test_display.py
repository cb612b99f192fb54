import math

import pytest

from tierod.core.findings import Estimate
from tierod.core.shown import shown
from tierod.report.display import duration, evidence, interval, number, share, time_scale, words


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (4.0, "4"),
        (-0.0, "0"),
        (-12.345, "−12.35"),
        (0.00123456, "0.001235"),
        (123456.0, "123500"),
        (9.9996, "10"),
        (1e-7, "1.000e−07"),
        (float("nan"), "–"),
        (None, "–"),
    ],
)
def test_numbers_keep_their_significant_digits(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0 s"),
        (2.64, "2.64 s"),
        (60.0, "1 min"),
        (1811.0, "30 min 11 s"),
        (36000.0, "10 h"),
        (3599.7, "1 h"),
        (None, "–"),
    ],
)
def test_durations_read_like_a_clock(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("value", "spread", "expected"),
    [
        (12.43, 0.11, ("12.43", "12.21", "12.65", "N·m")),
        (-0.001, 1.0, ("0.0", "−2.0", "2.0", "N·m")),
        (4.0, 1.0, ("4.0", "2.0", "6.0", "N·m")),
        (400.0, 100.0, ("400", "204", "596", "N·m")),
        (4.0, math.nan, ("4.00", "–", "–", "N·m")),
        (math.nan, 0.1, ("–", "–", "–", "N·m")),
        (4.0, 0.0, ("4.00", "4.00", "4.00", "N·m")),
    ],
)
def test_an_estimate_is_rounded_by_its_own_uncertainty(value, spread, expected):
    assert interval(Estimate("friction", value, spread, "N*m")) == expected


def test_angles_are_shown_in_degrees():
    factor, label = shown("rad")
    assert (round(math.pi * factor, 9), label) == (180.0, "°")
    assert interval(Estimate("angle", math.pi, 0.1, "rad"))[::3] == ("180", "°")


def test_the_interval_of_a_root_mean_square_begins_at_zero():
    assert interval(Estimate("torque of the driver's hands, rms", 0.007, 0.017, "N*m"))[:3] == (
        "0.007",
        "0.000",
        "0.040",
    )
    assert interval(Estimate("torque", 0.007, 0.017, "N*m"))[1].startswith("−")


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("enabled_seconds", 130.0, ("Enabled", "2 min 10 s")),
        ("seconds", 60.0, ("Duration", "1 min")),
        ("enabled_share", 0.364, ("Enabled share", "36 %")),
        ("mean_nis", 0.9712, ("Mean NIS", "0.9712")),
        ("rate_hz", 100.0, ("Rate", "100 Hz")),
        ("bias_nm", 0.5, ("Bias", "0.5 N·m")),
        ("samples", 12, ("Samples", "12")),
        ("path", "a.csv", ("Path", "a.csv")),
        ("share", float("nan"), ("Share", "–")),
    ],
)
def test_evidence_carries_its_unit_in_its_name(name, value, expected):
    assert evidence(name, value) == expected


@pytest.mark.parametrize(("span", "label"), [(60.0, "s"), (3600.0, "min"), (36000.0, "h")])
def test_time_axes_suit_the_length_of_the_drive(span, label):
    assert time_scale(span)[1] == label


def test_small_shares_are_not_called_none():
    assert (share(0.004), share(0.0), share(1.0)) == ("0.4 %", "0 %", "100 %")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("driver_torque", "Driver torque"),
        ("filter.gate.minimum_rate", "Filter: gate: minimum rate"),
        ("3.2 to 6.5 min", "3.2 to 6.5 min"),
        ("mean_nis", "Mean NIS"),
    ],
)
def test_names_become_words(name, text):
    assert words(name) == text
