"""Mutated files and the corpus of all that ever failed, through the command line as users call it."""

import signal
import time

import pytest

from attack.corpus import load
from attack.crowds import CROWDS, commands
from attack.fuzz import SEED, TARGETS, Case, class_of, run
from attack.kills import COMMANDS
from attack.kills import run as kill
from attack.pool import Pool
from attack.seeds import seeds

COUNT = 2
"""Cases of each target in the suite: a few seconds for all of them. `make attack` runs thousands."""

FEW = 1
"""Cases of formats each of which takes a process of its own."""

PROCESSES = ("mdf", "process")

KEPT = load()

pytest.importorskip("asammdf")
pytest.importorskip("can")
pytest.importorskip("h5py")
pytest.importorskip("rosbags")


@pytest.fixture(scope="module")
def pool():
    with Pool() as found:
        yield found


@pytest.mark.parametrize("target", TARGETS)
def test_mutated_files_of(pool, target):
    count = FEW if TARGETS[target].family in PROCESSES else COUNT
    tally = run(target, range(count), SEED, pool)
    assert tally.cases == count
    assert [f"{each.key}: {class_of(result)}" for each, result in tally.failed] == []


@pytest.mark.parametrize(
    "name", [pytest.param(each.name, marks=[pytest.mark.slow] if each.slow else []) for each in KEPT]
)
def test_corpus(pool, name):
    kept = next(each for each in KEPT if each.name == name)
    assert kept.fault(kept.run(pool)) == ""


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_what_is_mutated_is_valid(pool, target):
    """A seed that is refused as it stands would be a test of one sentence alone."""
    chosen = TARGETS[target]
    for name, content in seeds()[target].items():
        accepted = []
        for _, command in chosen.commands[:1] if chosen.family in PROCESSES else chosen.commands:
            result = pool.run(Case(target, 0, 0, name, content, command).placed(pool.folder()))
            assert result.kind == "", result
            accepted.append(result.code in (0, 2))
        assert any(accepted), (name, result.stderr)


def test_a_death_and_one_that_waits_for_ever_are_seen(pool, monkeypatch):
    assert pool.run(["--version"]).kind == ""
    pool.process.send_signal(signal.SIGSEGV)
    result = pool.run(["--version"])
    assert (result.kind, result.detail) == ("crash", "SIGSEGV")
    assert pool.run(["--version"]).kind == ""
    monkeypatch.setattr(pool, "wait", 0.5)
    pool.process.send_signal(signal.SIGSTOP)
    began = time.monotonic()
    assert pool.run(["--version"]).kind == "hang"
    assert time.monotonic() - began >= 0.5


@pytest.mark.parametrize(
    ("answer", "stdout", "stderr", "kind"),
    [
        ({}, "all is well\n", "", ""),
        ({"code": 3}, "", "tierod: give another file\n", ""),
        ({"code": 3}, "", "", "silence"),
        ({"code": 3}, "", "x" * 5000, "flood"),
        ({"code": 3}, "", "tierod: not enough memory\n", "memory"),
        ({"code": 4, "where": "here"}, "", "tierod: a defect\n", "defect"),
        ({"code": 5}, "", "", "code"),
        ({"code": None, "escaped": "Traceback"}, "", "", "traceback"),
        ({}, "", "Traceback (most recent call last):\n", "traceback"),
        ({}, "\x1b[2J", "", "escape"),
        ({}, "", "\x9b31m", "escape"),
        ({"memory": 2e9}, "", "", "memory"),
        ({"seconds": 11.0}, "", "", "hang"),
    ],
)
def test_what_went_wrong_gets_its_name(answer, stdout, stderr, kind):
    with Pool() as silent:
        (silent.home / "stdout").write_text(stdout, encoding="utf-8")
        (silent.home / "stderr").write_text(stderr, encoding="utf-8")
        whole = {"code": 0, "escaped": "", "seconds": 0.1, "memory": 0, "resident": 0, **answer}
        assert silent.judged(whole).kind == kind


@pytest.mark.parametrize("count", [pytest.param(2, marks=pytest.mark.slow), 20])
@pytest.mark.parametrize("shared", CROWDS)
def test_a_crowd_loses_nothing_and_refuses_nothing_wrongly(tmp_path, shared, count):
    found = CROWDS[shared](count, seed=count, folder=tmp_path)
    assert found["processes"] == count
    assert found["wrong"] == 0, found


@pytest.mark.slow
def test_twenty_commands_at_once_count_each_recording_once(tmp_path):
    found = commands(20, seed=3, folder=tmp_path)
    assert found == {"processes": 20, "counted": 15, "refused": 5, "wrong": 0}


BAD = ("broken", "lost", "hindered", "strays")


@pytest.mark.slow
def test_all_commands_survive_many_kills(tmp_path):
    found = kill(60, seed=7, folder=tmp_path)
    assert set(found) == {each.name for each in COMMANDS}
    for name, figures in found.items():
        assert [figures[each] for each in BAD] == [0] * 4, (name, figures)
