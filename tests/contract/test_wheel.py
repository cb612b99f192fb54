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
PACKAGES = {"tierod": ROOT / "packages/tierod", "tierod_lab": ROOT / "packages/tierod-lab"}


def run(command, folder, environment=None):
    done = subprocess.run(
        [*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheels")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q", "wheel"]
    # Copies, since a build folder that is left over would put old files into the wheel.
    for name, package in PACKAGES.items():
        left_out = shutil.ignore_patterns("__pycache__", "build", "*.egg-info")
        shutil.copytree(package, folder / "source" / name, ignore=left_out)
    sources = (folder / "source").iterdir()
    code, _, said = run([*pip, "--no-deps", "--no-build-isolation", "--no-index", "-w", folder, *sources], ROOT)
    assert code == 0, said
    return {name: next(folder.glob(f"{name}-*.whl")) for name in PACKAGES}


def environment(folder, wheels):
    """An environment with some wheels; the libraries that they need are those of the one that runs the tests."""
    venv.create(folder, with_pip=False)
    site = next(folder.glob("lib/python*/site-packages"))
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(site)
    # Later on the path than what was installed, so that no other tierod comes first.
    libraries = folder / "libraries"
    libraries.mkdir()
    for each in Path(sysconfig.get_path("purelib")).iterdir():
        if "tierod" not in each.name.lower():
            (libraries / each.name).symlink_to(each)
    (site / "libraries.pth").write_text(f"{libraries}\n", encoding="utf-8")
    return folder / "bin" / "python"


@pytest.mark.parametrize("name", PACKAGES)
def test_a_wheel_holds_every_file_of_its_package(wheels, name):
    package = PACKAGES[name] / "src" / name
    files = [path for path in package.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    with zipfile.ZipFile(wheels[name]) as archive:
        held = set(archive.namelist())
    assert {path.relative_to(package.parent).as_posix() for path in files} <= held


@pytest.fixture
def clean(tmp_path):
    own = {"HOME": str(tmp_path), "TIEROD_CACHE": str(tmp_path / "cache")}
    return {"PATH": "/usr/bin:/bin", "TIEROD_CFLAGS": "-O0", **own}


def commanded(python, folder, clean, commands, codes=(0,)):
    """Run commands by one process of an environment; what it printed, first the place of tierod."""
    script = f"""
import tierod
from tierod.cli import main
print(tierod.__file__, flush=True)
for words in {commands}:
    code = main(words)
    assert code in {codes}, (words, code)
"""
    code, printed, said = run([python, "-c", script], folder, clean)
    assert code == 0, said
    return printed


def test_tierod_alone_judges(wheels, clean, tmp_path):
    python = environment(tmp_path / "environment", [wheels["tierod"]])
    commands = [["vehicles", "rav4"], ["demo"], ["monitors"], ["formats"], ["isolability"]]
    printed = commanded(python, tmp_path, clean, commands, (0, 1))
    assert Path(printed.splitlines()[0]).is_relative_to(tmp_path / "environment")
    assert "report:" in printed
    assert (tmp_path / "out" / "demo-friction.html").stat().st_size > 100_000
    code, _, said = run([python, "-m", "tierod", "simulate", "hands-off", "-o", "a.parquet"], tmp_path, clean)
    assert code == 3
    assert "needs the package tierod-lab" in said
