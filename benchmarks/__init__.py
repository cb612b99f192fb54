"""Measurements against peers, as ratios in the same run: `make bench`."""
