"""State estimators: blocks that turn a discrete model and its noise into estimates with a variance."""

from tierod.estimators.augment import augment
from tierod.estimators.kalman import KalmanFilter
from tierod.estimators.unscented import UnscentedFilter

__all__ = ["KalmanFilter", "UnscentedFilter", "augment"]
