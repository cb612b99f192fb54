"""Completion in shells, and the examples below the help."""

import os
import subprocess
import sys

import pytest

from tierod.cli import main
from tierod.cli.app import commands
from tierod.cli.examples import EXAMPLES


@pytest.mark.parametrize(("typed", "offered"), [("tierod diag", "diagnose"), ("tierod diagnose --base", "--baseline")])
def test_bash_completes_commands_and_options(typed, offered):
    asked = {"_TIEROD_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1)}
    ran = subprocess.run(
        [sys.executable, "-m", "tierod"], capture_output=True, text=True, env=os.environ | asked, check=False
    )
    assert offered in ran.stdout.split()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell_is_shown(shell, capsys, monkeypatch):
    # Else typer asks which shell runs this process, and a runner of tests may have none.
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    assert main(["--show-completion", shell]) == 0
    assert "_TIEROD_COMPLETE" in capsys.readouterr().out


def test_help_shows_examples_and_names(capsys):
    assert main(["new", "--help"]) == 0
    printed = capsys.readouterr().out
    assert "Example: tierod new car.toml --like midsize-eps" in printed
    assert "quadricycle, small, midsize" in printed


@pytest.mark.parametrize("verb", ["diagnose", "identify", "fleet", "replay"])
def test_help_shows_the_units_of_options(verb, capsys):
    assert main([verb, "--help"]) == 0
    assert "[s]." in " ".join(capsys.readouterr().out.replace("│", " ").split())


@pytest.mark.parametrize("verb", EXAMPLES)
def test_examples_are_of_commands_that_there_are(verb):
    assert verb in commands()
    for line in EXAMPLES[verb]:
        assert f"tierod {verb}" in line
