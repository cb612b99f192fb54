"""Benchmarks against peers, as ratios within the same run: `make bench`."""
