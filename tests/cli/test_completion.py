"""The scripts for shells, and the examples below the help."""

import shlex
import shutil
import subprocess

import pytest

from tierod.cli import main
from tierod.cli.app import commands
from tierod.cli.examples import EXAMPLES


def completed(script, *words):
    """What bash would offer for the last of the words."""
    line = " ".join(map(shlex.quote, words))
    asked = f"{script}\nCOMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _tierod; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    return subprocess.run(["bash", "-c", asked], capture_output=True, text=True, check=True).stdout.split()


@pytest.fixture(scope="module")
def scripts():
    """By shell, as printed."""
    import contextlib
    import io

    found = {}
    for shell in ("bash", "zsh", "fish"):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            assert main(["completion", shell]) == 0
        found[shell] = printed.getvalue()
    return found


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_completes_commands_options_and_names(scripts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = scripts["bash"]
    assert completed(script, "tierod", "diag") == ["diagnose"]
    assert completed(script, "tierod", "diagnose", "--base") == ["--baseline"]
    assert completed(script, "tierod", "diagnose", "a.mf4", "--monitor", "side") == ["sideslip"]
    assert completed(script, "tierod", "new", "--like", "ferr") == ["ferrari-250lm"]
    assert completed(script, "tierod", "new", "--class", "qu") == ["quadricycle"]
    assert completed(script, "tierod", "identify", "col") == ["column"]
    assert completed(script, "tierod", "inspect", "my") == []  # bash completes files itself


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_is_in_every_script(shell, scripts):
    for verb in commands():
        assert verb in scripts[shell]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_read_their_script(shell, scripts):
    if shutil.which(shell) is None:
        pytest.skip(f"there is no {shell}")
    subprocess.run([shell, "-n", "-c", scripts[shell]], check=True)


def test_an_unknown_shell_is_an_error(capsys):
    assert main(["completion", "bsh"]) == 3
    assert "did you mean 'bash'" in capsys.readouterr().err


def test_help_shows_examples_and_names(capsys):
    assert main(["new", "--help"]) == 0
    printed = capsys.readouterr().out
    assert "Example: tierod new car.toml --like midsize-eps" in printed
    assert "quadricycle, small, midsize" in printed


@pytest.mark.parametrize("verb", EXAMPLES)
def test_examples_are_of_commands_that_there_are(verb):
    assert verb in commands()
    for line in EXAMPLES[verb]:
        assert f"tierod {verb}" in line
