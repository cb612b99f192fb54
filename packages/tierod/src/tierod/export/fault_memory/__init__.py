"""Export of the fault memory for control units."""
