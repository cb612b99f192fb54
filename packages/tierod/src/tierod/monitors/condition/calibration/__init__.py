"""Calibration from fault-free drives: parameters of the vehicle, and limits of the log-likelihood ratios."""
