"""Friction of the steering: the estimators of paper 000 and the ones that go beyond it."""
