"""The fault memory for control units."""
