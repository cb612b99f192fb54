"""Detectors: blocks that turn a residual into a statistic and a decision, with what their constants cost."""

from tierod.detectors.counter import GatedCounter
from tierod.detectors.cusum import Cusum
from tierod.detectors.geometric_average import GeometricAverage
from tierod.detectors.held_threshold import HeldThreshold
from tierod.detectors.likelihood_ratio import LikelihoodRatio
from tierod.detectors.moments import BatchMoments, ExponentialMoments, Moments, MovingMoments
from tierod.detectors.sequential_test import SequentialTest
from tierod.detectors.threshold import Condition, Debounce, Hysteresis
from tierod.detectors.two_sided import TwoSided
from tierod.detectors.value import Value

__all__ = [
    "BatchMoments",
    "Condition",
    "Cusum",
    "Debounce",
    "ExponentialMoments",
    "GatedCounter",
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
