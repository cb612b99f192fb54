import errno
import os
import subprocess
import sys
import types
import warnings
from pathlib import Path

import numpy as np
import pytest

from tierod import __version__
from tierod.cli import app, main
from tierod.cli.app import commands
from tierod.cli.examples import EXAMPLES
from tierod.core.errors import InputError, KernelWarning
from tierod.io.readers import read


@pytest.fixture
def verb(monkeypatch):
    """A command that does what the test says."""

    def install(function):
        function.__name__ = "vehicles"
        module = types.ModuleType("tierod.cli.vehicles", "Do what the test says.")
        module.vehicles = function
        monkeypatch.setitem(sys.modules, "tierod.cli.vehicles", module)
        return lambda *arguments: main(["vehicles", *arguments])

    return install


def raising(error):
    def function():
        raise error

    return function


@pytest.mark.parametrize("flag", ["--version", "-V"])
def test_says_its_version(flag, capsys):
    assert main([flag]) == 0
    assert capsys.readouterr().out == f"tierod {__version__}\n"


def test_help_lists_every_command_with_its_summary(capsys):
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    for command in app.commands():
        assert any(line.split()[:1] == [command] and len(line.split()) > 3 for line in printed.splitlines())


def test_no_command_is_a_usage_error_that_shows_the_help(capsys):
    assert main([]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Usage: tierod COMMAND" in captured.err


def test_an_unknown_command_names_the_nearest(capsys):
    assert main(["vehicels"]) == 3
    assert "did you mean 'vehicles'?" in capsys.readouterr().err


@pytest.mark.parametrize(("given", "code"), [(0, 0), (1, 1), (2, 2), (None, 0)])
def test_a_command_decides_the_exit_code(verb, given, code):
    assert verb(lambda: given)() == code


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (InputError("the file is\nhalf; give the whole"), 3, "tierod: the file is half; give the whole\n"),
        (MemoryError(), 3, "not enough memory"),
        (
            PermissionError(errno.EACCES, "Permission denied", "a.csv"),
            3,
            "a.csv: permission denied; check the permissions",
        ),
        (OSError(errno.ENOSPC, "No space left on device"), 3, "no space left on device; make room"),
        (ZeroDivisionError("division by zero"), 4, "a defect of tierod itself: ZeroDivisionError"),
        (KeyboardInterrupt(), 130, "stopped"),
    ],
)
def test_what_goes_wrong_becomes_one_line(verb, capsys, error, code, sentence):
    assert verb(raising(error))() == code
    captured = capsys.readouterr()
    assert sentence in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""


def test_a_sentence_that_repeats_a_file_is_shortened(verb, capsys):
    assert verb(raising(InputError(f"there is no column {'x' * 100_000}; name another one")))() == 3
    said = capsys.readouterr().err
    assert len(said) < app.LONGEST_SENTENCE + 50
    assert said.startswith("tierod: there is no column xxx")
    assert said.endswith("xxx; name another one\n")


def test_debug_shows_the_traceback(verb):
    with pytest.raises(ZeroDivisionError):
        verb(raising(ZeroDivisionError()))("--debug")


def test_usage_errors_end_with_three_not_two(capsys):
    assert main(["vehicles", "--jsn"]) == 3
    assert main(["vehicles", "one", "two"]) == 3
    assert capsys.readouterr().err.count("see 'tierod vehicles --help'") == 2


def test_a_reader_that_goes_away_ends_quietly():
    command = f"{sys.executable} -c 'from tierod.cli import main; raise SystemExit(main())' vehicles --json | head -c 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout == "{"
    assert done.stderr == ""


@pytest.mark.parametrize(("lines", "code"), [(1, 1), (100_000, 141)])
def test_a_verdict_is_never_healthy_where_no_reader_comes(verb, monkeypatch, lines, code):
    reading, writing = os.pipe()
    os.close(reading)

    def judge():
        for _ in range(lines):
            print("fault")
        return 1

    stdout = os.fdopen(writing, "w")
    monkeypatch.setattr(sys, "stdout", stdout)
    assert verb(judge)() == code
    stdout.close()


PROGRAM = f"{sys.executable} -P -m tierod"


@pytest.mark.parametrize(
    ("command", "code"),
    [
        ("vehicles <&- >&- 2>&-", 141), ("--version >&-", 141), ("vehicles none >&-", 3),
        ("vehicles 2>&- >/dev/null", 0), ("vehicles none 2>/dev/full", 3), ("--version >/dev/full", 3),
    ],
)  # fmt: skip
def test_closed_streams_end_with_a_code_and_without_a_traceback(tmp_path, command, code):
    if "full" in command and not Path("/dev/full").is_char_device():
        pytest.skip("this system has no /dev/full")
    done = subprocess.run(f"{PROGRAM} {command}", shell=True, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert "defect" not in done.stderr


def test_a_file_never_takes_the_place_of_a_closed_output(tmp_path):
    (tmp_path / "in.csv").write_text("time,yaw_rate [rad/s]\n" + "".join(f"{k / 100},{k}\n" for k in range(50)))
    command = f"{PROGRAM} convert in.csv -o out.csv >&- 2>&-"
    assert subprocess.run(command, shell=True, cwd=tmp_path, check=False).returncode == 141
    (channel,) = read(tmp_path / "out.csv").channels.values()
    assert np.array_equal(channel.values, np.arange(50.0))


def test_warnings_are_sentences_without_a_place_in_the_code(monkeypatch, capsys):
    def warn(_):
        warnings.warn("the cache is full. Kernels are kept elsewhere", KernelWarning, stacklevel=1)
        warnings.warn("numbers overflow", RuntimeWarning, stacklevel=1)
        return 0

    monkeypatch.setattr(app, "_dispatch", warn)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert app.run([]) == 0
    error = capsys.readouterr().err.splitlines()
    assert error[0] == "tierod: the cache is full. Kernels are kept elsewhere"
    assert error[1].startswith("tierod: a library warns of 'numbers overflow'")


@pytest.mark.parametrize(("typed", "offered"), [("tierod diag", "diagnose"), ("tierod diagnose --base", "--baseline")])
def test_bash_completes_commands_and_options(typed, offered):
    asked = {"_TIEROD_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1)}
    ran = subprocess.run(
        [sys.executable, "-m", "tierod"], capture_output=True, text=True, env=os.environ | asked, check=False
    )
    assert offered in ran.stdout.split()


@pytest.mark.parametrize("verb", ["diagnose", "identify", "fleet", "replay"])
def test_help_shows_the_units_of_options(verb, capsys):
    assert main([verb, "--help"]) == 0
    assert "[s]." in " ".join(capsys.readouterr().out.replace("│", " ").split())


@pytest.mark.parametrize("verb", EXAMPLES)
def test_examples_are_of_commands_that_there_are(verb):
    assert verb in commands()
    for line in EXAMPLES[verb]:
        assert f"tierod {verb}" in line
