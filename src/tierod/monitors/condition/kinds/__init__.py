"""Kind of a sensor's fault, and its magnitude."""
