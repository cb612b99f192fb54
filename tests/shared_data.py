"""Where the real recordings are, for tests that need one."""

import os
from pathlib import Path

import pytest


def shared_data(*parts: str) -> Path:
    """The path of a shared recording; skips the test, with the reason, where it is absent."""
    root = Path(os.environ.get("TIEROD_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
    path = root.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"the recording {'/'.join(parts)} is not here; set TIEROD_DATA to the folder that holds it")
    return path
