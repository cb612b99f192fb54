import json

import pytest

from tierod.cli import main
from tierod_lab.ground.faults import BEHAVIOURS, load, shipped


def test_lists_what_is_shipped_with_a_sentence_each(capsys):
    assert main(["faults"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    for name in shipped():
        assert name in printed
    assert "The yaw rate sensor reads zero for 20 s." in printed


@pytest.mark.parametrize("name", shipped())
def test_shows_element_behaviour_and_time(name, capsys):
    assert main(["faults", name]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    file = load(name)
    assert file.description in printed
    assert file.source in printed
    for effect in file.fault.effects:
        assert effect.element.split("|")[0].strip() in printed
    assert "Begins" in printed
    assert f'use = "{name}"' in printed


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("friction-step", "step: to 12.5 N*m Begins at 30 s, lasts until the end."),
        ("yaw-rate-offset", "offset: size 0.3 rad/s Begins at 20 s, lasts 20 s."),
        ("yaw-rate-outlier", "outlier: factor 3 Begins at 20 s, lasts 1 s."),
        ("driver-torque-drift", "drift: rate 0.00333333 N*m/s, limit 1 N*m"),
        ("friction-intermittent", "intermittent: (step: to 12.5 N*m), mean on 5 s, mean off 20 s"),
        ("vehicle-speed-stuck", "Begins when vehicle_speed > 50 km/h for 1 s"),
        ("heavy-load", "Begins from the beginning"),
    ],
)
def test_words(name, words, capsys):
    main(["faults", name])
    assert words in " ".join(capsys.readouterr().out.split())


def test_prints_a_file_to_begin_with(capsys, tmp_path):
    assert main(["faults", "tyre-pressure-low", "--toml"]) == 0
    mine = tmp_path / "tyre-pressure-low.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    assert load(mine).fault == load("tyre-pressure-low").fault
    assert main(["faults", str(mine)]) == 0
    assert "use =" in capsys.readouterr().out


def test_shows_one_fault_as_json(capsys):
    assert main(["faults", "yaw-rate-offset", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["effects"] == [{"element": "sensor.yaw_rate", "behaviour": {"kind": "offset", "size": 0.3}}]
    assert document["trigger"] == {"kind": "at-time", "time": 20.0}
    assert document["duration"] == 20.0


def test_shows_all_as_json(capsys):
    assert main(["faults", "--json"]) == 0
    assert [each["name"] for each in json.loads(capsys.readouterr().out)["faults"]] == list(shipped())


def test_lists_how_elements_can_behave(capsys):
    assert main(["faults", "--behaviours"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in BEHAVIOURS)
    assert main(["faults", "--behaviours", "--json"]) == 0
    drift = next(each for each in json.loads(capsys.readouterr().out)["behaviours"] if each["name"] == "drift")
    assert drift["fields"] == "rate [unit of the element/s], (limit [unit of the element])"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--toml"], "--toml needs a fault"),
        (["friction-step", "--toml", "--json"], "exclude each other"),
        (["friction-step", "--behaviours"], "leave 'friction-step' out"),
        (["friction-stp"], "did you mean 'friction-step'"),
        (["absent.toml"], "there is no fault file"),
    ],
)
def test_wrong_use_is_reported(arguments, sentence, capsys):
    assert main(["faults", *arguments]) == 3
    assert sentence in capsys.readouterr().err
