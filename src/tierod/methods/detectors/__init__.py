"""Detectors: blocks that turn a residual into a statistic and a decision, and the design of their thresholds."""

from tierod.methods.detectors.control_charts import Cusum, GeometricAverage, HeldThreshold
from tierod.methods.detectors.likelihood_ratio import LikelihoodRatio
from tierod.methods.detectors.moments import BatchMoments, ExponentialMoments, Moments, MovingMoments
from tierod.methods.detectors.sequential_test import SequentialTest, TwoSided
from tierod.methods.detectors.threshold import Debounce, Hysteresis
from tierod.methods.detectors.value import Condition, Detector, Value

__all__ = [
    "BatchMoments",
    "Condition",
    "Cusum",
    "Debounce",
    "Detector",
    "ExponentialMoments",
    "GeometricAverage",
    "HeldThreshold",
    "Hysteresis",
    "LikelihoodRatio",
    "Moments",
    "MovingMoments",
    "SequentialTest",
    "TwoSided",
    "Value",
]
