"""Identification of parameters from recordings made for the purpose."""
