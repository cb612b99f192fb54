"""State estimators: blocks that compute estimates with variances from a discrete model and its noise."""

from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.observers import FixedLag, Luenberger, StationaryGain, stationary_gain
from tierod.methods.estimators.shapes import augment
from tierod.methods.estimators.stationary_bank import StationaryBank

__all__ = [
    "FixedLag",
    "KalmanFilter",
    "Luenberger",
    "StationaryBank",
    "StationaryGain",
    "augment",
    "stationary_gain",
]
