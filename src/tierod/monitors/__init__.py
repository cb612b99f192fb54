"""Monitors: estimators, gates and detectors put together to judge one part of a steering."""
