"""Friction of the steering: the estimators of Mohtat et al. and the ones that go beyond it."""
