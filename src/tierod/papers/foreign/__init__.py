"""Monitors on plants that this project did not write, or that share nothing with it."""
