"""Verbs of the command line that need the virtual vehicle, one file per verb."""
