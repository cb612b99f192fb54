import subprocess
import sys

import pytest

from tierod.monitors.registry import MONITORS


@pytest.mark.parametrize("name", MONITORS)
def test_a_monitor_stands_under_its_own_name(name):
    assert MONITORS[name].name == name


def test_a_monitor_that_is_not_run_is_not_loaded():
    code = "import sys; from tierod.monitors.registry import MONITORS; MONITORS['friction']; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "tierod.monitors.friction.definition" in loaded
    assert "tierod.monitors.sideslip.definition" not in loaded
    assert len(MONITORS) == len(list(MONITORS))
