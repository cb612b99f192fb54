"""Estimators and filters that only methods as printed in papers use."""
