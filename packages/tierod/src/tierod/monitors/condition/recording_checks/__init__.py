"""Checks of a recording for defects that are no fault of a sensor: wiring, scale, time, gaps, inputs of the filters."""
