"""Detectors: blocks that turn a residual into a statistic and a decision, and the design of their thresholds."""

from tierod.methods.detectors.control_charts import (
    Condition,
    Cusum,
    Debounce,
    Detector,
    GeometricAverage,
    HeldThreshold,
    Value,
)
from tierod.methods.detectors.likelihood_tests import LikelihoodRatio, Moments, MovingMoments, SequentialTest, TwoSided

__all__ = [
    "Condition",
    "Cusum",
    "Debounce",
    "Detector",
    "GeometricAverage",
    "HeldThreshold",
    "LikelihoodRatio",
    "Moments",
    "MovingMoments",
    "SequentialTest",
    "TwoSided",
    "Value",
]
