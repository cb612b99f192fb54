"""The default observer of a motor's angle beside motulator's, in the benchmark's own process."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_it_is_ten_times_better_with_a_warm_winding_and_not_worse_with_a_known_one():
    pytest.importorskip("motulator")
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.motulator_peer", "--json"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    rows = json.loads(done.stdout)
    error = {(row["resistance"], row["observer"]): row["error"] for row in rows}
    peers = ("motulator, 40 Hz", "motulator, 100 Hz")
    for speed in ("0.02", "0.05", "0.1"):
        assert 10.0 * error[1.2, "ours, increments when slow"][speed] < min(error[1.2, peer][speed] for peer in peers)
    for speed in ("0.05", "0.1"):
        best = min(error[1.0, peer][speed] for peer in peers)
        assert error[1.0, "ours, increments when slow"][speed] <= 1.02 * best
