import json
from importlib.util import find_spec

import numpy as np
import pytest

from report_pages import Page, charts
from tierod.cli import main
from tierod.cli.design import seconds_between
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write

WISH = ["design", "detector", "--false-alarms", "1 per 100 h", "--shift", "1.2", "--rate", "100"]


def test_it_shows_threshold_and_delay_of_every_rule_and_draws_the_curves(tmp_path, capsys):
    page = tmp_path / "detector.html"
    assert main([*WISH, "--sigma", "0.4", "-o", str(page)]) == 0
    printed = capsys.readouterr().out
    for rule in ("cusum", "hold", "threshold"):
        assert rule in printed
    text = page.read_text()
    assert "What fewer false alarms cost" in text
    assert "How soon shifts of other sizes are found" in text
    assert "white, standard deviation 0.4" in text
    assert "<p>design, " in text
    assert "do not hold" not in text  # nothing of a study's page


def test_one_rule_as_json(capsys):
    assert main([*WISH, "--sigma", "0.4", "--rule", "cusum", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rules"]
    assert row["seconds_between_false_alarms"] == 360000.0
    # Siegmund: exp(2 k b) / (2 k^2) / 2 sides = 3.6e7 samples for k = 1.5.
    assert row["threshold"] / 0.4 == pytest.approx(np.log(3.6e7 * 9.0) / 3.0 - 1.166, rel=0.03)
    assert 0.02 < row["delay_s"] < 0.08


@pytest.fixture
def healthy(tmp_path):
    path, time = tmp_path / "healthy.parquet", np.arange(200_000) / 100.0
    values = 0.01 * np.random.default_rng(1).normal(size=len(time))
    write(Recording({"yaw_rate": Channel("yaw_rate", time, values, "rad/s")}), path)
    return path


def test_a_threshold_measured_on_a_healthy_recording(healthy, tmp_path, capsys):
    path, page = healthy, tmp_path / "page.html"
    wish = ["design", "detector", "--false-alarms", "1 per 60 s", "--shift", "0.01", "--rate", "100"]
    assert main([*wish, "--residual", str(path), "--signal", "yaw_rate", "--json", "-o", str(page)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["deviation"] == pytest.approx(0.01, rel=0.02)
    assert found["interval_s"][0] < 60.0 < found["interval_s"][1]
    assert not found["extrapolated"]
    assert found["delay_median_s"] < found["delay_p95_s"] < 1.0
    assert "Time between false alarms, measured" in page.read_text()


def test_a_page_never_replaces_the_recording(healthy, capsys):
    before = healthy.read_bytes()
    arguments = [*WISH, "--residual", str(healthy), "--signal", "yaw_rate", "-o", str(healthy)]
    assert main(arguments) == 3
    assert "would overwrite" in capsys.readouterr().err
    assert healthy.read_bytes() == before


@pytest.mark.parametrize(
    ("text", "seconds"), [("1 per 10000 h", 3.6e7), ("2 per 60 s", 30.0), ("1e-3 per h", 3.6e6), ("1 per d", 86400.0)]
)
def test_false_alarms_in_words(text, seconds):
    assert seconds_between(text) == pytest.approx(seconds)


@pytest.fixture
def empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_demonstrator_is_reported_in_tables_and_on_a_page(empty, capsys):
    assert main(["isolability", "--vehicle", "smartload"]) == 0
    printed = capsys.readouterr().out
    for result in ("not separable from steering motor 2", "from its current", "smartload-isolability.html"):
        assert result in printed
    text = (empty / "smartload-isolability.html").read_text(encoding="utf-8")
    seen = Page(text)
    assert seen.open == []
    assert len(set(seen.identifiers)) == len(seen.identifiers)
    assert list(charts(text)) == ["isolability"]


def test_json_is_one_document_and_shows_what_a_poorer_car_confuses(empty, capsys):
    lacking = ("tie_rod_force", "longitudinal_acceleration", "lateral_acceleration")
    poorer = [word for name in lacking for word in ("--without", name)]
    assert main(["isolability", "--vehicle", "smartload", *poorer, "--json", "--no-report"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "tierod.isolability/2"
    assert "tie_rod_force" not in document["faults"]
    poor = document["views"]["forces of tyres and tie rods unknown"]
    (group,) = poor["not_isolable"]
    assert {"steering_wheel_angle", "steering_shaft_torque", "steering_motor_1"} <= set(group)
    assert list(empty.iterdir()) == []


needs_fmpy = pytest.mark.skipif(find_spec("fmpy") is None, reason="fmpy is not installed")


def validate_fmu(path):
    """Remarks of fmpy on a unit."""
    from fmpy.validation import validate_fmu as validate

    return validate(path)


def test_a_monitor_is_exported_with_the_drive_it_is_compared_by(tmp_path, capsys):
    words = ["export", "c", "sideslip", "--vehicle", "midsize-eps", "-o", str(tmp_path / "ecu")]
    assert main(words) == 0
    assert "make -C" in capsys.readouterr().out
    assert "slalom-winter-tyres" in (tmp_path / "ecu/README.md").read_text()
    assert (tmp_path / "ecu/test/expected.csv").read_text().startswith("step,")


@needs_fmpy
@pytest.mark.parametrize("what", ["plant", "driver", "assist"])
def test_what_a_scenario_drives_with_becomes_a_unit(tmp_path, capsys, what):
    words = ["export", "fmu", what, "--scenario", "weave-small-car", "-o", str(tmp_path / "a.fmu")]
    assert main(words) == 0
    assert "FMI 2.0 co-simulation" in capsys.readouterr().out
    assert validate_fmu(str(tmp_path / "a.fmu")) == []


def test_a_readme_of_the_user_is_not_overwritten(tmp_path, capsys):
    (tmp_path / "README.md").write_text("mine")
    assert main(["export", "c", "sideslip", "--vehicle", "midsize-eps", "-o", str(tmp_path)]) == 3
    assert "name a folder of its own" in capsys.readouterr().err
    assert (tmp_path / "README.md").read_text() == "mine"
