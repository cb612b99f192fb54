"""Monitors on a live bus: receiving, judging while driving, logging, replaying."""
