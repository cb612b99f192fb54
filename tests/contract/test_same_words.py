"""One statement has the same word, symbol and colour in every place that shows it."""

from __future__ import annotations

import dataclasses
import io
import json
import re

import pytest
from rich.console import Console

from fleet.drives import NOVEMBER, judged
from live_drives import START, driven, messages, started
from stated_monitor import drive
from tierod.cli import main
from tierod.core.findings import Status
from tierod.io.writers import write
from tierod.live.outputs import Outputs
from tierod.monitors.diagnose import diagnose
from tierod.monitors.registry import MONITORS
from tierod.monitors.runner import Chosen
from tierod.report import print_table

GOOD, WATCH, BAD, OPEN = "good", "watch", "bad", "open"
LOOKS = {
    "fault": ("✕", BAD),
    "rising": ("▲", WATCH),
    "suspect": ("▲", WATCH),
    "inconsistent": ("▲", WATCH),
    "not available": ("?", OPEN),
    "not identifiable": ("?", OPEN),
    "not testable": ("?", OPEN),
    "not enabled": ("?", OPEN),
    "not ready": ("?", OPEN),
    "estimated": ("≈", OPEN),
    "consistent": ("✓", GOOD),
    "healthy": ("✓", GOOD),
}
"""Symbol and colour of every status, the worst first."""

COLOURS = {"31": BAD, "32": GOOD, "33": WATCH, "36": OPEN}  # Colours by the codes of a terminal

EXIT_CODES = {"fault": 1, "rising": 1, "suspect": 1, "inconsistent": 1, "estimated": 0, "consistent": 0, "healthy": 0}

Looks = tuple[str, str, str]  # Word, symbol and colour


@pytest.fixture(autouse=True)
def stated(monkeypatch):
    monkeypatch.setitem(MONITORS.own, "stated", "stated_monitor:STATED")
    yield
    MONITORS._loaded.pop("stated", None)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("stated")
    for status in Status:
        write(drive(status, origin=NOVEMBER, vehicle_file="midsize-eps"), made / f"{status.name.lower()}.parquet")
    return made


def console() -> Console:
    return Console(file=io.StringIO(), force_terminal=True, color_system="standard", width=300)


def in_terminal(text: str) -> list[Looks]:
    found = re.findall(r"\x1b\[1;(3\d)m(\S) ([A-Za-z ]+?) *\x1b\[0m", text)
    return [(word.lower(), symbol, COLOURS[colour]) for colour, symbol, word in found]


def in_json(content) -> Looks:
    return content["status"], content["symbol"], content["colour"]


def badges(html: str) -> list[Looks]:
    place = (
        r'<section class="verdict (\w+)[^>]*>\s*<p class="status">\s*<span class="badge"><span aria-hidden="true">(.)'
    )
    found = re.findall(rf"{place}</span>\s*<a [^>]*>([^<]+)</a>", html)
    return [(word, symbol, colour) for colour, symbol, word in found]


def states(html: str) -> list[Looks]:
    found = re.findall(r'<span class="state (\w+)"><span aria-hidden="true">(.)</span> ([^<]+)</span>', html)
    return [(word, symbol, colour) for colour, symbol, word in found]


def name_of(word: str) -> str:
    return f"{word.replace(' ', '_')}.parquet"


@pytest.mark.parametrize("word", LOOKS)
def test_a_diagnosis_shows_the_same_in_terminal_json_and_report(word, folder, tmp_path, capsys):
    expected = (word, *LOOKS[word])
    page = tmp_path / "page.html"
    command = ["diagnose", str(folder / name_of(word)), "--monitor", "stated", "--json", "-o", str(page)]
    assert main(command) == EXIT_CODES.get(word, 2)
    content = json.loads(capsys.readouterr().out)
    assert [in_json(each) for each in (content, *content["findings"], *content["elements"])] == 3 * [expected]
    assert content["exit_code"] == EXIT_CODES.get(word, 2)
    html = page.read_text(encoding="utf-8")
    assert badges(html) == states(html) == [expected]
    screen = console()
    print_table(diagnose(folder / name_of(word), None, "stated"), screen)
    assert in_terminal(screen.file.getvalue()) == [expected, expected]


def test_a_fleet_shows_the_same_on_its_page_in_its_document_and_for_a_car(folder, tmp_path):
    from tierod.fleet.judging import Asked
    from tierod.fleet.ranking import Ranked, Reason, Urgency
    from tierod.fleet.report import document, report
    from tierod.fleet.report_page import render
    from tierod.web.fleets import drives_of

    run = judged(folder, tmp_path / "results", asked=Asked((Chosen("stated"),), spread=False))
    assert run.statuses == {"stated": dict.fromkeys(LOOKS, 2)}  # the whole, and its only sensor
    found = report(tmp_path / "results")
    rows = [row for row, judged_part in enumerate(found.findings["judged"].to_pylist()) if not judged_part]
    words = [found.findings["status"][row].as_py() for row in rows]
    expected = [(word, *LOOKS[word]) for word in words]
    assert sorted(words) == sorted(LOOKS)
    reasons = [Reason(Urgency.FAULT, "why", "what", None, tuple(part)) for part in (rows[:6], rows[6:])]
    named = dataclasses.replace(found, cars=tuple(Ranked(str(at), (each,)) for at, each in enumerate(reasons)))
    drives = [row for car in document(named)["cars"] for each in car["reasons"] for row in each["drives"]]
    assert [in_json(each) for each in drives] == expected
    assert states(render(named)) == expected
    assert sorted(
        row["status"] for row in drives_of(tmp_path / "results", "midsize-eps") if not row["judged"]
    ) == sorted(LOOKS)


def frames(folder, word):
    from tierod.live.replay import encoded

    found = encoded(folder / name_of(word), messages(folder), None)
    return [frame._replace(time=START + 0.25 + frame.time) for frame in found]


@pytest.mark.parametrize("word", LOOKS)
def test_a_live_drive_shows_the_same_in_its_events_and_in_the_terminal(word, folder, tmp_path):
    from tierod.live.view import picture

    expected = (word, *LOOKS[word])
    going, inbox, events = started(tmp_path, Outputs(), monitors=("stated",))
    driven(going, inbox, frames(folder, word)[:600])
    screen = console()
    screen.print(picture(going))
    assert in_terminal(screen.file.getvalue()) == [expected]
    assert [in_json(each) for each in going.state()["monitors"]] == [expected]
    going.close()
    said = [each for each in events if each["event"] == "verdict"]
    assert in_json(said[-1]) == expected
    end = events[-1]
    assert in_json(end) == in_json(end["verdicts"]["stated"]) == expected


@pytest.mark.parametrize("word", LOOKS)
def test_the_web_page_gets_the_same_from_its_endpoint_and_its_script(word, folder, tmp_path):
    pytest.importorskip("fastapi", reason="the extra 'web' is not installed")
    from tierod.web.analysing import Reading, analyse
    from tierod.web.app import files
    from tierod.web.store import Store

    store = Store(tmp_path)
    key = analyse(store, Reading(folder / name_of(word)), "midsize-eps", False, lambda *_, **__: None)["result"]
    content = json.loads((store.path("results", key) / "result.json").read_text(encoding="utf-8"))
    assert in_json(content["monitors"]["stated"]) == (word, *LOOKS[word])
    (table,) = map(json.loads, re.findall(r"const STATUSES = (\{.*\});", files().content["statuses.js"].decode()))
    assert table[word] == [*LOOKS[word]][::-1]
