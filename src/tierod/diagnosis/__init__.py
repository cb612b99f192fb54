"""Handling of findings: trouble codes, the memory of faults, and its readout for a workshop."""
