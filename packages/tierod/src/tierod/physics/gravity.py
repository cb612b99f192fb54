"""Gravitational acceleration."""

from __future__ import annotations

GRAVITY = 9.81  # Gravitational acceleration [m/s**2], rounded as usual in vehicle dynamics
