"""The named time span of a fault contains it: onset, declaration and end differ, and the kind comes from inside."""

import json
import math
import re

import pytest

from monitors.condition.motion_alone import SETS, drive
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.io.writers import write
from tierod.monitors.diagnose import diagnose
from tierod.report.document import document
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import DRIFT, NOISE, OFFSET, STUCK, Drive, Injected
from tierod_lab.papers.condition.recorded import recorded

LEFT, YAW = "wheel_speed_rear_left", "yaw_rate"
BEGIN, LASTING = 36.0, 10.0


def wheel(kind, size, start=BEGIN, before=15.0, after=20.0):
    """A wheel that is wrong for ten seconds, of a car with two wheel speeds, yaw rate, angle and accelerations."""
    made = drive(3, 120.0)
    part = Recording({name: made[name] for name in SETS["without front wheels"]}).slice(start - before, start + after)
    return injected(part, [Injected(LEFT, kind, size, start, start + LASTING).fault])


def diagnosed(made, vehicle="rav4", variant=None):
    return diagnose(made, vehicle, "condition", variant, spread=False)


def episode_of(diagnosis, name=LEFT):
    """The only episode of the only element that is named."""
    (element,) = (each for each in diagnosis.elements if each.episodes)
    assert element.name == name
    (episode,) = element.episodes
    return episode


@pytest.mark.parametrize(
    ("kind", "size", "within", "start"),
    [(STUCK, math.nan, 0.1, 36.0), (DRIFT, 0.15, 2.0, 52.0), (DRIFT, -0.1, 3.0, 36.0)],
)
def test_a_wheel_that_is_found_only_when_it_returns_is_dated_to_its_fault(kind, size, within, start):
    episode = episode_of(diagnosed(wheel(kind, size, start)))
    assert episode.declared > start + LASTING
    assert (episode.start, episode.end) == (pytest.approx(start, abs=within), pytest.approx(start + LASTING, abs=0.1))
    assert episode.kind == kind
    if kind == DRIFT:
        low, high = (episode.magnitude.value + side * 3.0 * episode.magnitude.standard_deviation for side in (-1, 1))
        assert low < size < high


def test_the_three_times_stand_in_document_terminal_and_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write(wheel(DRIFT, 0.15), "drive.parquet")
    drifting = diagnosed(wheel(DRIFT, 0.15))
    finding, episode = drifting.findings[0], episode_of(drifting)
    assert f"from {episode.start:.2f} s to 46.00 s (declared at {episode.declared:.2f} s)" in finding.details[0]
    told = json.loads(document(drifting, series=False))
    (written,) = (each for element in told["elements"] for each in element["episodes"])
    times = [episode.start, episode.end, episode.declared]
    assert [written[key] for key in ("start", "end", "declared")] == times
    assert [told["findings"][0][key] for key in ("since", "end", "declared")] == times
    assert main(["diagnose", "drive.parquet", "--vehicle", "rav4", "--monitor", "condition", "--details"]) == 1
    told, page = capsys.readouterr().out, (tmp_path / "drive-condition.html").read_text(encoding="utf-8")
    for text in (told, page.replace("\N{NO-BREAK SPACE}", " ")):
        text = " ".join(text.split())
        assert re.search(r"change began at 3\d\.\d+ s, ended at 46 s, declared at 46\.02 s", text)
        assert "to 46.00 s (declared at 46.02 s)" in text


def test_a_fault_that_has_ended_has_an_end_though_the_file_ends_before_it_is_withdrawn():
    assert episode_of(diagnosed(wheel(DRIFT, 0.15, after=LASTING + 2.5))).end == pytest.approx(46.0, abs=0.1)


def test_a_finding_of_two_faults_ends_with_the_last():
    made = drive(3, 120.0)
    part = Recording({name: made[name] for name in SETS["without front wheels"]}).slice(21.0, 66.0)
    found = diagnosed(injected(part, [Injected(LEFT, OFFSET, 1.0, at, at + 5.0).fault for at in (30.0, 45.0)]))
    assert found.findings[0].since == pytest.approx(30.0, abs=0.1)
    assert found.findings[0].end == pytest.approx(50.0, abs=0.5)


def test_a_fault_that_lasts_has_no_end():
    diagnosis = diagnosed(wheel(STUCK, math.nan, 28.0, after=9.0))
    assert all(each.end is None for element in diagnosis.elements for each in element.episodes)
    assert diagnosis.findings[0].end is None


def test_noise_of_a_wheel_is_never_noise_of_nothing():
    episode = episode_of(diagnosed(wheel(NOISE, 0.5)))
    assert (episode.kind, episode.magnitude.value) == ("noise", pytest.approx(0.5, rel=0.2))


def test_a_rule_that_holds_late_leaves_the_onset_where_its_residual_began():
    made = injected(recorded(Drive("long-round", 40.0, 1, 11)), [Injected(YAW, OFFSET, 0.2, 15.0, 30.0).fault])
    diagnosis = diagnosed(made, "smartload", "rules")
    episode = episode_of(diagnosis, YAW)
    assert episode.declared > 20.0
    assert (episode.start, episode.end) == (pytest.approx(15.0, abs=0.3), pytest.approx(30.0, abs=0.3))
    assert diagnosis.findings[0].since == episode.start
