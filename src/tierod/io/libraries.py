"""Check that a library of a format is installed, without importing it."""

from __future__ import annotations

import importlib.util

from tierod.core.errors import MissingExtra


def require_library(library: str, extra: str, purpose: str) -> None:
    """Raise MissingExtra where a library is not installed."""
    try:
        found = importlib.util.find_spec(library)
    except ValueError:
        found = None
    if found is None:
        raise MissingExtra(library, extra, purpose)
