"""Defects of a recording that are no fault of any sensor: wiring, scale, time, gaps."""
