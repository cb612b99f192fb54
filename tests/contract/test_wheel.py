"""The built wheel holds all that tierod needs, and works from an empty environment in a foreign folder."""

import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "tierod"


def run(command, folder, environment=None):
    done = subprocess.run(
        [*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q", "wheel"]
    # A copy, since a build folder that is left over would put old files into the wheel.
    source = folder / "source"
    shutil.copytree(PACKAGE, source / "src" / "tierod", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    code, _, said = run([*pip, "--no-deps", "--no-build-isolation", "--no-index", "-w", folder, source], ROOT)
    assert code == 0, said
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory):
    """An environment with the wheel; the libraries that tierod needs are those of the one that runs the tests."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    site = next(folder.glob("lib/python*/site-packages"))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    # Later on the path than what was installed, so that no other tierod comes first.
    (site / "libraries.pth").write_text(f"{sysconfig.get_path('purelib')}\n", encoding="utf-8")
    return folder


def test_the_wheel_holds_every_file_of_the_package(wheel):
    files = [path for path in PACKAGE.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    assert {path.relative_to(PACKAGE.parent).as_posix() for path in files} <= held


def test_commands_run_from_the_wheel_in_a_foreign_folder(environment, tmp_path):
    python = environment / "bin" / "python"
    own = {"HOME": str(tmp_path), "TIEROD_CACHE": str(tmp_path / "cache")}
    clean = {"PATH": "/usr/bin:/bin", "TIEROD_CFLAGS": "-O0", **own}
    code, printed, said = run([python, "-m", "tierod", "vehicles", "rav4"], tmp_path, clean)
    assert code == 0, said
    assert "rav4" in printed
    judging = ["diagnose", "out/demo-drive.parquet", "--vehicle", "midsize-eps", "--json"]
    commands = (["demo", "--minutes", "3"], ["monitors"], ["formats"], ["faults"], ["scenarios"], ["isolability"])
    script = f"""
import tierod
from tierod.cli import main
print(tierod.__file__, flush=True)
assert [main(words) for words in {commands}] == [0] * {len(commands)}
assert main({judging}) in (0, 1)
"""
    code, printed, said = run([python, "-c", script], tmp_path, clean)
    assert code == 0, said
    assert Path(printed.splitlines()[0]).is_relative_to(environment)
    assert "report:" in printed
    assert (tmp_path / "demo-drive-friction.html").stat().st_size > 100_000
