"""tierod runs without the package tierod-lab; what needs it says so in one sentence, and which to install."""

import subprocess
import sys

import pytest

import tierod
from tierod.core.version import __version__

WITHOUT = """
import importlib.metadata, sys
points = importlib.metadata.entry_points
lab = ("tierod.lab", "tierod.variants")
importlib.metadata.entry_points = lambda group: () if group.startswith(lab) else points(group=group)
sys.modules["tierod_lab"] = None
from tierod.cli import main
sys.exit(main(sys.argv[1:]))
"""


OTHER = """
import importlib.metadata, sys
from tierod.core import plugins as lab
lab.__version__ = "99.0"
from tierod.cli import main
sys.exit(main(sys.argv[1:]))
"""


def run(code, *arguments):
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("words", [["simulate"], ["campaign"], ["study", "--help"], ["scenarios"]])
def test_a_verb_of_the_lab_names_the_package_to_install(words):
    verb, (code, printed, said) = words[0], run(WITHOUT, *words)
    assert (code, printed) == (3, "")
    assert said.count("\n") == 1
    assert f"'tierod {verb}' needs the package tierod-lab {__version__}, which is not installed" in said
    assert f"pip install tierod-lab=={__version__}" in said


def test_tierod_alone_lists_its_own_verbs_and_judges_its_demo(tmp_path):
    code, printed, _ = run(WITHOUT, "--help")
    assert code == 0
    assert "simulate" not in printed
    code, printed, said = run(WITHOUT, "demo", "-o", str(tmp_path))
    assert code in (0, 1), said
    assert "FAULT" in printed
    assert (tmp_path / "demo-friction.html").stat().st_size > 100_000


def test_a_variant_of_a_paper_names_the_package(tmp_path):
    tierod.write(tierod.simulate("hands-off", seconds=5.0).recording, tmp_path / "drive.parquet")
    command = ["diagnose", str(tmp_path / "drive.parquet"), "--vehicle", "midsize-eps", "--monitor", "friction"]
    code, _, said = run(WITHOUT, *command, "--variant", "refined")
    assert code == 3
    assert "has no variant 'refined'; known: pre-sliding. Those of the papers are in the package tierod-lab" in said


def test_a_lab_of_another_version_is_named():
    code, _, said = run(OTHER, "scenarios")
    assert code == 3
    assert f"is installed in version {__version__}; pip install tierod-lab==99.0" in said
    code, printed, said = run(OTHER, "--help")
    assert (code, "simulate" in printed, said) == (0, False, "")
