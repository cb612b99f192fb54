"""Libraries of the formats: whether they are installed, without importing them, and without what they log."""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import Iterator
from contextlib import contextmanager

from tierod.core.errors import MissingExtra


def require_library(library: str, extra: str, purpose: str) -> None:
    """Raise MissingExtra where a library is not installed."""
    try:
        found = importlib.util.find_spec(library)
    except ValueError:
        found = None
    if found is None:
        raise MissingExtra(library, extra, purpose)


@contextmanager
def muted(library: str, level: int) -> Iterator[None]:
    """Suppress what a library logs below a level."""
    logger = logging.getLogger(library)
    before = logger.level
    logger.setLevel(level)
    try:
        yield
    finally:
        logger.setLevel(before)
