"""Identification of parameters from recordings: of a bench, or of ordinary drives."""
