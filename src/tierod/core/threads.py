"""Number of threads that the libraries for linear algebra may start."""

from __future__ import annotations

import os

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that limit them, read when they are loaded."""


def one_thread_each() -> None:
    """Let them use one thread unless the user chose: a sum over a drive costs several waiting cores more than it saves.

    And the last digit of a sum would depend on the number of cores.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
