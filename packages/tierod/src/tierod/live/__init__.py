"""Monitoring on a live bus: receiving, judging while driving, logging, and replaying."""
