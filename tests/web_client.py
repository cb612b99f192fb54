"""The test client of starlette, which warns where httpx is there in place of its successor."""

from __future__ import annotations

import warnings

import pytest

pytest.importorskip("fastapi", reason="the extra 'web' is not installed")

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

__all__ = ["TestClient"]
