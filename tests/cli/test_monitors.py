import json

import pytest

from tierod.cli import main
from tierod.monitors.registry import MONITORS


@pytest.mark.parametrize("name", MONITORS)
def test_shows_signals_variants_and_sources(name, capsys):
    assert main(["monitors", name]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    monitor = MONITORS[name]
    for text in (monitor.title, monitor.summary, *monitor.required, *monitor.variants):
        assert text in printed


def test_tells_the_default_or_that_there_is_none(capsys):
    main(["monitors", "friction"])
    assert "the default is pre-sliding" in capsys.readouterr().out
    main(["monitors", "hysteresis"])
    printed = capsys.readouterr().out
    assert "no default: choose one with --variant" in printed
    assert "Only if this is a lock-to-lock test of the standing car." in printed


def test_tells_what_a_variant_needs_in_place_of_the_monitors_signals(capsys):
    main(["monitors", "motor-angle"])
    printed = " ".join(capsys.readouterr().out.split())
    assert (
        "commanded-voltage needs motor_target_voltage_alpha, motor_target_voltage_beta in place of "
        "motor_voltage_alpha, motor_voltage_beta." in printed
    )
    assert "stator-frame needs" not in printed


@pytest.mark.parametrize("monitor", MONITORS.values())
def test_every_default_is_a_variant(monitor):
    assert monitor.default is None or monitor.default in monitor.variants


def test_lists_all_as_json(capsys):
    assert main(["monitors", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["monitors"]
    assert [each["name"] for each in listed] == list(MONITORS)
    assert all(each["variants"] for each in listed)
    defaults = {each["name"]: each["default"] for each in listed}
    assert defaults["friction"] == "pre-sliding"
    assert defaults["hysteresis"] is None
    assert defaults["sideslip"] == "combined"


def test_an_unknown_monitor_names_the_nearest(capsys):
    assert main(["monitors", "fricton"]) == 3
    assert "did you mean 'friction'" in capsys.readouterr().err
