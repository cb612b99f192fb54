"""Detectors: blocks that turn a residual into a statistic and a decision, with what their constants cost."""

from tierod.detectors.counter import GatedCounter
from tierod.detectors.cusum import Cusum
from tierod.detectors.moments import BatchMoments, ExponentialMoments, Moments, MovingMoments
from tierod.detectors.threshold import Condition, Debounce, Hysteresis
from tierod.detectors.value import Value

__all__ = [
    "BatchMoments",
    "Condition",
    "Cusum",
    "Debounce",
    "ExponentialMoments",
    "GatedCounter",
    "Hysteresis",
    "Moments",
    "MovingMoments",
    "Value",
]
