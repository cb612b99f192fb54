"""Monitors: each combines estimators, gates and detectors to judge one part of a steering system."""
