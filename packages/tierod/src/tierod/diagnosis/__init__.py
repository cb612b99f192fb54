"""Handling of findings: trouble codes, fault memory, and its readout by a workshop tester."""
