"""Gravity."""

from __future__ import annotations

GRAVITY = 9.81
"""Acceleration of free fall [m/s**2], rounded as usual in vehicle dynamics."""
