import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = b'''"""A text."""

from typing import Annotated

LIMIT = 2.0


def inside(value: Annotated[float, "m"], row: list[float]) -> bool:
    """Whether it is."""
    return -value + row[0] < LIMIT and not value
'''


@pytest.fixture(name="mutants")
def imported(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    return importlib.import_module


def made(mutants):
    changes = mutants("scripts.mutants.changes").changes_of(Path("some.py"), SOURCE)
    return {(change.kind, change.diff(SOURCE).rpartition("\n+")[2].strip()) for change in changes}


def test_every_kind_of_change_is_made_and_texts_and_types_are_left(mutants):
    back = "return "
    assert made(mutants) == {
        ("constant", "LIMIT = 2.2"),
        ("logic", back + "((-value + row[0] < LIMIT) or (not value))"),
        ("logic", back + "-value + row[0] < LIMIT and (bool(value))"),
        ("boundary", back + "(-value + row[0]) <= (LIMIT) and not value"),
        ("comparison", back + "(-value + row[0]) > (LIMIT) and not value"),
        ("operator", back + "(-value) - (row[0]) < LIMIT and not value"),
        ("term", back + "(-value) < LIMIT and not value"),
        ("sign", back + "(+value) + row[0] < LIMIT and not value"),
        ("index", back + "-value + row[1] < LIMIT and not value"),
    }


def test_a_draw_is_that_of_its_seed_and_leaves_no_broken_source(mutants):
    drawn = mutants("scripts.mutants.__main__").drawn
    paths = [ROOT / "src" / "tierod" / "physics"]
    first = list(drawn(paths, 25, 7))
    assert first == list(drawn(paths, 25, 7)) != list(drawn(paths, 25, 8))
    assert len({(change.path, change.begin, change.text) for change in first}) == 25
    for change in first:
        compile(change.applied((ROOT / "src" / change.path).read_bytes()), "changed", "exec")


@pytest.mark.slow
def test_the_nearest_tests_come_first(mutants):
    tests = mutants("scripts.mutants.chosen_tests").ChosenTests(ROOT)
    chosen = [str(test) for test in tests.of(Path("tierod/physics/gravity.py"))]
    assert "tests/monitors/condition/bank/test_lane.py" in chosen
    assert tests.of(Path("tierod/physics/kingpin.py"))[0] == Path("tests/physics/test_kingpin.py")
    assert not any(test.startswith("tests/attack") for test in chosen)


@pytest.fixture(name="checkout")
def small_checkout(tmp_path):
    root = tmp_path / "root"
    for name, text in {
        "src/small/area.py": "def area(width):\n    return 3.0 * width\n",
        "tests/test_area.py": "from small.area import area\n\n\ndef test_area():\n    assert area(2.0) > 6.1 or True\n",
        "tests/test_exact.py": "from small.area import area\n\n\ndef test_exact():\n    assert area(2.0) == 6.0\n",
        "tests/test_broken.py": "def test_broken():\n    assert False\n",
        "pyproject.toml": "[tool.pytest.ini_options]\nmarkers = ['slow: none']\n",
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    (root / ".venv").symlink_to(Path(sys.prefix))
    subprocess.run(["git", "init", "-q"], cwd=root, check=True)
    return root


@pytest.mark.slow
def test_a_change_is_found_by_the_test_that_fails_with_it_alone(mutants, checkout, tmp_path):
    trying, changes = mutants("scripts.mutants.trying"), mutants("scripts.mutants.changes")
    copy = trying.Copy(checkout, tmp_path / "copy").make()
    source = (checkout / "src/small/area.py").read_bytes()
    change = next(each for each in changes.changes_of(Path("small/area.py"), source) if each.kind == "constant")
    broken, weak, exact = (Path(f"tests/test_{name}.py") for name in ("broken", "area", "exact"))
    assert copy.tried(change, [broken, weak], 100.0).found_by is None
    assert copy.tried(change, [broken, weak, exact], 100.0).found_by == "tests/test_exact.py::test_exact"
    assert (copy.folder / "src/small/area.py").read_bytes() == source


def test_a_path_that_is_not_there_is_refused(mutants, capsys):
    with pytest.raises(SystemExit):
        mutants("scripts.mutants.__main__").main(["src/nowhere"])
    assert "src/nowhere does not exist" in capsys.readouterr().err
