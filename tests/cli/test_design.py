import json

import numpy as np
import pytest

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


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "--sigma"),
        (["--sigma", "-1"], "greater than zero"),
        (["--sigma", "0.4", "--rule", "cusm"], "did you mean 'cusum'"),
        (["--sigma", "0.4", "--false-alarms", "never"], "1 per 10000 h"),
        (["--sigma", "0.4", "--false-alarms", "0 per h"], "1 per 10000 h"),
        (["--sigma", "0.4", "--residual", "absent.parquet"], "either --sigma"),
        (["--residual", "absent.parquet"], "absent.parquet"),
        (["--sigma", "0.4", "--sides", "left"], "sides is 'left'"),
        (["--sigma", "0.4", "--signal", "yaw_rate"], "goes with --residual"),
        (["--sigma", "0.4", "--shift", "1e-6", "--false-alarms", "1 per 1e5 h"], "look for a larger shift"),
        (["--sigma", "0.4", "--false-alarms", "1 per 0.01 s"], "ask for more"),
    ],
)
def test_bad_use_is_reported_in_a_line(arguments, says, capsys):
    assert main([*WISH, *arguments]) == 3
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
