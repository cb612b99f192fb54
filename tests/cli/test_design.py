import json

import numpy as np
import pytest

from tierod.cli import main
from tierod.cli.design import seconds_between
from tierod.recording import Channel, Recording
from tierod.writers import write

WISH = ["design", "detector", "--false-alarms", "1 per 100 h", "--shift", "1.2", "--rate", "100"]


def test_it_tells_threshold_and_delay_of_every_rule_and_draws_the_curves(tmp_path, capsys):
    page = tmp_path / "detector.html"
    assert main([*WISH, "--sigma", "0.4", "-o", str(page)]) == 0
    printed = capsys.readouterr().out
    for rule in ("cusum", "average", "sequential", "hold", "threshold"):
        assert rule in printed
    text = page.read_text()
    assert "What fewer false alarms cost" in text
    assert "How soon shifts of other sizes are found" in text


def test_one_rule_as_json(capsys):
    assert main([*WISH, "--sigma", "0.4", "--rule", "cusum", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rules"]
    assert row["seconds_between_false_alarms"] == 360000.0
    # Siegmund: exp(2 k b) / (2 k^2) / 2 sides = 3.6e7 samples for k = 1.5.
    assert row["threshold"] / 0.4 == pytest.approx(np.log(3.6e7 * 9.0) / 3.0 - 1.166, rel=0.03)
    assert 0.02 < row["delay_s"] < 0.08


def test_a_threshold_measured_on_a_healthy_recording(tmp_path, capsys):
    path, page = tmp_path / "healthy.parquet", tmp_path / "page.html"
    time = np.arange(200_000) / 100.0
    values = 0.01 * np.random.default_rng(1).normal(size=len(time))
    write(Recording({"yaw_rate": Channel("yaw_rate", time, values, "rad/s")}), path)
    wish = ["design", "detector", "--false-alarms", "1 per 60 s", "--shift", "0.01", "--rate", "100"]
    assert main([*wish, "--residual", str(path), "--signal", "yaw_rate", "--json", "-o", str(page)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["deviation"] == pytest.approx(0.01, rel=0.02)
    assert found["interval_s"][0] < 60.0 < found["interval_s"][1]
    assert not found["extrapolated"]
    assert found["delay_median_s"] < found["delay_p95_s"] < 1.0
    assert "Time between false alarms, measured" in page.read_text()


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
        (["--sigma", "0.4", "--false-alarms", "1 per 0.01 s"], "ask for more"),
    ],
)
def test_bad_use_is_told_in_a_line(arguments, says, capsys):
    assert main([*WISH, *arguments]) == 3
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
