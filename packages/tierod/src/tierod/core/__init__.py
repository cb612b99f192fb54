"""Foundations of all packages: blocks and their graph, fields, units, signals, recordings, findings, errors, files."""
