"""Settings of all tests: no time limit on a shared machine; the same examples each time where a change is checked."""

import gc
import os

import pytest
from hypothesis import settings

from tierod.core.threads import one_thread_each

# As in every command, and before NumPy is loaded: threads that wait for each other cost tests three times the work.
one_thread_each()

settings.register_profile("tierod", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("tierod")

# Compilation takes a third of all tests' time as shipped, and a tenth so; results are the same to the last bit, which
# the tests that ask for `shipped_kernels` show.
os.environ.setdefault("TIEROD_CFLAGS", "-O1 -fno-schedule-insns -fno-ira-loop-pressure -ftree-loop-vectorize")


def pytest_collection_finish():
    """What was imported and collected stays to the end: no search for garbage need look through it."""
    gc.freeze()


@pytest.fixture
def shipped_kernels(monkeypatch):
    """Compile as users do."""
    monkeypatch.delenv("TIEROD_CFLAGS", raising=False)
