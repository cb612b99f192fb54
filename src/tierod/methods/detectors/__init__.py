"""Detectors: blocks that turn a residual into a statistic and a decision, with what their constants cost."""

from tierod.methods.detectors.counter import GatedCounter
from tierod.methods.detectors.cusum import Cusum
from tierod.methods.detectors.geometric_average import GeometricAverage
from tierod.methods.detectors.held_threshold import HeldThreshold
from tierod.methods.detectors.likelihood_ratio import LikelihoodRatio
from tierod.methods.detectors.moments import BatchMoments, ExponentialMoments, Moments, MovingMoments
from tierod.methods.detectors.sequential_test import SequentialTest
from tierod.methods.detectors.threshold import Condition, Debounce, Hysteresis
from tierod.methods.detectors.two_sided import TwoSided
from tierod.methods.detectors.value import Value

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
