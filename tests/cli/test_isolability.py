"""What 'tierod isolability' prints and writes, and what it refuses."""

import json

import pytest

from report_pages import Page, charts
from tierod.cli import main


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_demonstrator_is_reported_in_tables_and_on_a_page(place, capsys):
    assert main(["isolability", "--vehicle", "smartload"]) == 0
    printed = capsys.readouterr().out
    for result in (
        "not separable from steering motor 2",
        "from its current",
        "smartload-isolability.html",
    ):
        assert result in printed
    text = (place / "smartload-isolability.html").read_text(encoding="utf-8")
    seen = Page(text)
    assert seen.open == []
    assert len(set(seen.identifiers)) == len(seen.identifiers)
    assert list(charts(text)) == ["isolability"]


def test_json_is_one_document_and_shows_what_a_poorer_car_confuses(place, capsys):
    poorer = [
        "--without",
        "tie_rod_force",
        "--without",
        "longitudinal_acceleration",
        "--without",
        "lateral_acceleration",
    ]
    assert main(["isolability", "--vehicle", "smartload", *poorer, "--json", "--no-report"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "tierod.isolability/2"
    assert "tie_rod_force" not in document["faults"]
    poor = document["views"]["forces of tyres and tie rods unknown"]
    (group,) = poor["not_isolable"]
    assert {"steering_wheel_angle", "steering_shaft_torque", "steering_motor_1"} <= set(group)
    assert list(place.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "result"),
    [
        (["--without", "tie_rod_forze"], "tie_rod_force"),
        (["--vehicle", "midsize-eps"], "midsize-eps"),
        (["--vehicle", "smartlod"], "smartload"),
    ],
)
def test_bad_input_is_named(place, capsys, arguments, result):
    assert main(["isolability", *arguments]) == 3
    said = capsys.readouterr().err
    assert result in said
    assert "Traceback" not in said


@pytest.mark.parametrize("command", [["isolability"], ["diagnose", "drive.csv", "--vehicle", "midsize-eps"]])
def test_a_report_that_is_named_and_not_wanted_is_refused(command, tmp_path, capsys):
    assert main([*command, "--no-report", "-o", str(tmp_path / "x.html")]) == 3
    assert "exclude each other" in capsys.readouterr().err
