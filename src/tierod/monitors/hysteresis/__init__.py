"""Friction from a turn lock to lock, on the hoist or on the ground."""
