"""Mutated files and the corpus of all that ever failed, through the command line as users call it."""

import pytest

from attack.corpus import load
from attack.crowds import CROWDS
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


@pytest.mark.parametrize("count", [pytest.param(2, marks=pytest.mark.slow), 20])
@pytest.mark.parametrize("shared", CROWDS)
def test_a_crowd_loses_nothing_and_refuses_nothing_wrongly(tmp_path, shared, count):
    found = CROWDS[shared](count, seed=count, folder=tmp_path)
    assert found["processes"] == count
    assert found["wrong"] == 0, found


BAD = ("broken", "lost", "hindered", "strays")


@pytest.mark.slow
def test_all_commands_survive_many_kills(tmp_path):
    found = kill(60, seed=7, folder=tmp_path)
    assert set(found) == {each.name for each in COMMANDS}
    for name, figures in found.items():
        assert [figures[each] for each in BAD] == [0] * 4, (name, figures)
