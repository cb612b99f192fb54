import json
import math
import sys

import pytest

from tierod.cli import terminal
from tierod.cli.terminal import print_json, progress, rows


def test_numbers_that_json_cannot_hold_become_null(capsys):
    print_json({"a": math.nan, "b": [1.5, -math.inf, ("x", None)]})
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": [1.5, None, ["x", None]]}


def test_json_text_is_passed_through_with_one_line_end(capsys):
    print_json('{"a": 1}\n\n')
    assert capsys.readouterr().out == '{"a": 1}\n'


def test_square_brackets_in_a_table_are_text(capsys):
    terminal.output().print(rows(("channel",), [("ASAM_[15].M",)]))
    assert "ASAM_[15].M" in capsys.readouterr().out


class Clock:
    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now


@pytest.mark.parametrize(("seconds", "shown"), [(0.5, False), (1.5, True)])
def test_progress_appears_after_a_second_and_never_on_stdout(monkeypatch, capsys, seconds, shown):
    clock = Clock()
    monkeypatch.setattr(terminal, "time", clock)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with progress("reading") as advance:
        advance(0.1)
        clock.now = seconds
        advance(0.9)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert ("reading" in captured.err) is shown


def test_progress_stays_silent_without_a_terminal(monkeypatch, capsys):
    clock = Clock()
    monkeypatch.setattr(terminal, "time", clock)
    with progress("reading") as advance:
        clock.now = 5.0
        advance(0.9)
    assert capsys.readouterr().err == ""
