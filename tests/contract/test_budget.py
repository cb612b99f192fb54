"""The size of every folder and of the docs stays within budget.toml, which only falls."""

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "budget.py"


def test_nothing_is_above_its_budget():
    spec = importlib.util.spec_from_file_location("budget", SCRIPT)
    budget = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(budget)
    assert not budget.complaints(), "\n".join(budget.complaints())
