"""What 'tierod analyse' prints and writes, and what it refuses."""

import json
import shutil

import numpy as np
import pytest

from methods.analysis.column_sets import column
from report_pages import Page, charts
from tierod.cli import main
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod.models.linear import sampled
from tierod.vehicles import load


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def bench():
    """The linear column of the bench, shaken by noise for half a minute."""
    rng = np.random.default_rng(5)
    steps = sampled(column("S1"), 1e-3)
    torque = rng.normal(size=30_000)
    state, outputs = np.zeros(6), np.empty((len(torque), 3))
    for k, value in enumerate(torque):
        outputs[k] = steps.C @ state
        state = steps.A @ state + steps.B[:, 0] * value
    time = np.arange(len(torque)) * 1e-3
    units = ("rad", "rad", "N*m")
    measured = [Channel(name, time, outputs[:, k], units[k]) for k, name in enumerate(steps.outputs)]
    return Recording({}).with_channels([Channel("motor_torque", time, torque, "N*m"), *measured])


def analyse(*arguments):
    return main(["analyse", *map(str, arguments)])


def test_a_column_is_reported_in_tables_and_on_a_page(place, capsys):
    assert analyse("column", "--vehicle", "column-bench") == 0
    printed = capsys.readouterr().out
    for result in ("12.69", "112.5", "0.123", "an artefact of", "mechanical,", "page: column-bench-column.html"):
        assert result in printed
    text = (place / "column-bench-column.html").read_text(encoding="utf-8")
    seen = Page(text)
    assert seen.open == []
    assert len(set(seen.identifiers)) == len(seen.identifiers)
    assert list(charts(text)) == ["bode-reduced"]


def test_json_is_one_document_and_all_else_goes_elsewhere(place, capsys):
    assert analyse("column", "--vehicle", "column-bench", "--json", "-o", "page.html") == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert "page: page.html" in captured.err
    assert document["schema"] == "tierod.analysis/1"
    assert (document["subject"], document["vehicle"]) == ("column", "column-bench")
    fastest = document["eigenvalues"][-1]
    assert fastest["imaginary"] == pytest.approx(706.750702, abs=1e-5)
    everything = document["observability_with_torques"][-1]
    assert everything["ranks"]["staircase"] == everything["ranks"]["PBH"] == 8
    assert everything["ranks"]["unscaled matrix"] == 5
    names = [reduction["name"] for reduction in document["reductions"]]
    assert names[:3] == ["mechanical, series", "mechanical, torsion bar", "mechanical, printed"]
    assert "measured" not in document


def test_a_recording_is_compared_with_the_model(place, bench, capsys):
    write(bench, "bench.parquet")
    assert analyse("column", "--vehicle", "column-bench", "--recording", "bench.parquet", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    measured = result["measured"]
    assert result["remarks"] == []
    assert measured["fits"]
    assert measured["differences"]["driver_torque"]["root_mean_square_db"] < 1.0
    assert (measured["input"], measured["rate"]) == ("motor_torque", 1000.0)
    bar = {key: np.array(values) for key, values in measured["responses"]["driver_torque"].items()}
    known = (bar["frequency"] > 1.0) & (bar["frequency"] < 60.0) & (np.abs(bar["frequency"] - 12.7) > 3.0)
    np.testing.assert_allclose(bar["gain"][known], bar["model_gain"][known], rtol=0.1)
    assert np.median(bar["coherence"]) > 0.99
    text = (place / "column-bench-column.html").read_text(encoding="utf-8")
    assert "measured-driver-torque" in charts(text)
    assert "bench.<wbr>parquet" in text


def test_a_recording_that_does_not_fit_the_model_is_said_to(place, bench, capsys):
    weaker = Channel("motor_torque", bench["motor_torque"].time, 0.1 * bench["motor_torque"].values, "N*m")
    write(bench.with_channels([weaker]), "other.parquet")
    arguments = ("column", "--vehicle", "column-bench", "--recording", "other.parquet", "--no-report")
    assert analyse(*arguments, "--json") == 2
    result = json.loads(capsys.readouterr().out)
    assert not result["measured"]["fits"]
    assert "does not fit the model" in result["remarks"][0]
    assert result["measured"]["differences"]["driver_torque"]["root_mean_square_db"] == pytest.approx(20.0, abs=0.5)
    assert analyse(*arguments) == 2
    printed = capsys.readouterr().out
    assert "Measured over computed gain" in printed
    assert "driver torque 20 dB" in printed.replace("\n", " ")


def test_a_recording_whose_sensors_do_not_follow_the_motor_shows_nothing(place, bench, capsys):
    noise = np.random.default_rng(8).normal(size=len(bench["motor_torque"].time))
    write(bench.with_channels([Channel("motor_torque", bench["motor_torque"].time, noise, "N*m")]), "other.parquet")
    arguments = ("column", "--vehicle", "column-bench", "--recording", "other.parquet", "--no-report", "--json")
    assert analyse(*arguments) == 2
    assert "cannot be compared with the model" in json.loads(capsys.readouterr().out)["remarks"][0]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda bench: {"motor_torque": None}, "no motor_torque or motor_target_torque"),
        (lambda bench: dict.fromkeys(column().outputs), "no steering_wheel_angle or motor_angle_mechanical or driver_"),
        (lambda bench: {"motor_torque": 0.0 * bench["motor_torque"].values}, "motor_torque of the recording does not"),
    ],
)
def test_a_recording_that_says_nothing_is_refused(place, bench, capsys, change, sentence):
    changes = change(bench)
    kept = {name: channel for name, channel in bench.channels.items() if changes.get(name, 0) is not None}
    still = {name: values for name, values in changes.items() if values is not None}
    moved = [Channel(name, bench[name].time, values, bench[name].unit) for name, values in still.items()]
    write(Recording(kept).with_channels(moved), "bench.parquet")
    assert analyse("column", "--vehicle", "column-bench", "--recording", "bench.parquet") == 3
    captured = capsys.readouterr()
    assert sentence in captured.err
    assert captured.err.count("\n") == 1
    assert not (place / "column-bench-column.html").exists()


def test_a_recording_too_slow_for_a_frequency_response_is_refused(place, capsys):
    time, random = np.arange(400.0), np.random.default_rng(1)
    torques = {name: Channel(name, time, random.normal(size=400), "N*m") for name in ("motor_torque", "driver_torque")}
    write(Recording(torques), "slow.parquet")
    assert analyse("column", "--vehicle", "column-bench", "--recording", "slow.parquet") == 3
    error = capsys.readouterr().err
    assert "come at 1 Hz" in error
    assert "record at 200 Hz" in error


def test_unknown_subjects_and_lacking_parameters_are_named(place, capsys):
    assert analyse("colum", "--vehicle", "column-bench") == 3
    assert "did you mean 'column'?" in capsys.readouterr().err
    assert analyse("column", "--vehicle", "rav4") == 3
    assert "lacks" in capsys.readouterr().err
    assert list(place.iterdir()) == []


def test_a_column_that_would_move_on_its_own_is_refused_with_its_eigenvalue(place, capsys):
    shutil.copy(load("column-bench").path, place / "odd.toml")
    text = (place / "odd.toml").read_text(encoding="utf-8")
    (place / "odd.toml").write_text(text.replace("value = 0.2286477177", "value = 0.0"), encoding="utf-8")
    assert analyse("column", "--vehicle", "odd.toml", "--no-report") == 0
    capsys.readouterr()
    wrong = text.replace("value = 7.259936574", "value = -7.259936574")
    (place / "odd.toml").write_text(wrong, encoding="utf-8")
    assert analyse("column", "--vehicle", "odd.toml", "--no-report") == 3
    assert "gear_stiffness" in capsys.readouterr().err


def test_a_page_is_never_written_over_what_was_given(place, capsys):
    shutil.copy(load("column-bench").path, place / "own.toml")
    assert analyse("column", "--vehicle", "own.toml", "-o", "own.toml") == 3
    assert "would overwrite own.toml" in capsys.readouterr().err
