"""Friction from a lock-to-lock turn, on the hoist or on the ground."""
