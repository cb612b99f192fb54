"""Settings of all tests: no time limit on a shared machine; the same examples each time where a change is checked."""

import gc
import os
from functools import lru_cache

import pytest
from hypothesis import settings

from tierod.core.processes import one_thread_each

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


@pytest.fixture(scope="module")
def kernels_in_a_moment():
    """Compile without optimisation, in a third of the time: for modules that run kernels of their own for a moment.

    Such kernels compute the same to the last bit and run three times as long; no other module gets them.
    """
    from tierod.core.graph import kernel

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIEROD_CFLAGS", "-O0")
        patch.setattr(kernel, "_attempted", lru_cache(maxsize=512)(kernel._attempted.__wrapped__))
        yield
