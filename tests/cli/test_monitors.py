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


def test_shows_the_default_or_that_there_is_none(capsys):
    main(["monitors", "friction"])
    assert "the default is pre-sliding" in capsys.readouterr().out
    main(["monitors", "hysteresis"])
    printed = capsys.readouterr().out
    assert "no default: choose one with --variant" in printed
    assert "Only if this is a lock-to-lock test of the standing car." in printed


def test_shows_what_a_variant_needs_in_place_of_the_monitors_signals(capsys):
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


def test_shows_the_decisions_with_their_false_alarms(capsys):
    assert main(["monitors", "friction", "--json"]) == 0
    variants = json.loads(capsys.readouterr().out)["monitors"][0]["variants"]
    (rising,) = (each for each in variants[0]["decisions"] if each["name"] == "rising, baseline")
    assert rising["mean_between_false_alarms"] == 65.0
    assert rising["unit"] == "h"
    assert rising["demonstrated"]["alarms"] == 0
    assert rising["demonstrated"]["fewer_per_unit_95"] == pytest.approx(
        3.0 / rising["demonstrated"]["observed"], rel=0.01
    )
    main(["monitors", "friction"])
    assert "Decisions of the variant pre-sliding" in capsys.readouterr().out


def test_says_which_parameters_and_signals_a_vehicle_lacks(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "car.channels.toml").write_text('[signals.yaw_rate]\nsource = "yaw"\n')
    assert main(["new", "car.toml", "--class", "midsize"]) == 0
    capsys.readouterr()
    assert main(["monitors", "motor-angle", "--vehicle", "car.toml"]) == 0
    printed = capsys.readouterr().out
    assert "motor-angle: cannot run with car" in printed
    assert "motor_flux" in printed
    assert "motor_current_alpha" in printed
    assert main(["monitors", "motor-angle", "--vehicle", "motor-bench", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["monitors"].values()
    assert found["stator-frame"]["needed"] == []
    assert found["stator-frame"]["needed_signals"] is None


def test_ranks_the_guesses_of_a_vehicle_file_and_lists_no_default_of_another_kind_of_car(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "car.toml", "--class", "midsize"]) == 0
    capsys.readouterr()
    assert main(["monitors", "sideslip", "--vehicle", "car.toml"]) == 0
    printed = capsys.readouterr().out
    assert "steering_ratio" in printed
    assert "known to ±8%" in printed
    assert "'tierod diagnose' ranks the guesses" in printed
    assert main(["monitors", "sideslip", "--vehicle", "car.toml", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["monitors"].values()
    guessed = found["combined"]["guessed"]
    assert guessed.index("front_cornering_stiffness") < guessed.index("rear_distance")
    assert not {"wheelbase", "yaw_rate_noise"} & set(guessed)
    assert "power_assist_factor" not in found["combined"]["optional"]
    assert "yaw_rate_noise" in found["combined"]["optional"]
