"""Detectors: blocks that turn a residual into a statistic and a decision, and the design of their thresholds."""

from tierod.methods.detectors.control_charts import Cusum, GeometricAverage, HeldThreshold
from tierod.methods.detectors.likelihood_ratio import LikelihoodRatio
from tierod.methods.detectors.moments import Moments, MovingMoments
from tierod.methods.detectors.sequential_test import SequentialTest, TwoSided
from tierod.methods.detectors.threshold import Debounce
from tierod.methods.detectors.value import Condition, Detector, Value

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
