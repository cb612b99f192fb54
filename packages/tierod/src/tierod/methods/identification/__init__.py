"""Identification of parameters from recordings of a test bench or of ordinary drives."""
