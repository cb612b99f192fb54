"""Limit on the number of threads that the libraries for linear algebra start."""

from __future__ import annotations

import os

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that limit the threads; a library reads them when it is loaded."""


def one_thread_each() -> None:
    """Limit each library to one thread, unless the user chose another number.

    For a sum over a drive several waiting threads cost more than they save, and the last digit of the sum would depend
    on the number of cores.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
