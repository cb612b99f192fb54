"""Condition monitoring of a whole vehicle: drives of the demonstrator, their scoring, and the study."""
