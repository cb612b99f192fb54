"""Kills of `attack.kills`: nothing breaks, what was finished is kept, and the next run works.

In `make test` fault memories, live logs and campaigns are killed: diagnosis/test_store, live/test_kills,
experiments/test_running.
"""

import pytest

from attack.kills import COMMANDS, run
from tierod.core.graph.compiler import cache_folder

BAD = ("broken", "lost", "hindered", "strays")


@pytest.mark.slow
def test_a_command_that_is_killed_breaks_and_loses_nothing(tmp_path):
    """Of all commands the one that writes most; the cache of the user is at hand, and is not emptied."""
    found = run(1, seed=50, folder=tmp_path, names=("diagnose again",), cache=cache_folder())["diagnose again"]
    assert found["runs"] == found["killed"] == 1, "the test kills something"
    assert [found[each] for each in BAD] == [0] * 4, found


@pytest.mark.slow
def test_all_commands_survive_many_kills(tmp_path):
    found = run(60, seed=7, folder=tmp_path)
    assert set(found) == {each.name for each in COMMANDS}
    for name, figures in found.items():
        assert [figures[each] for each in BAD] == [0] * 4, (name, figures)
