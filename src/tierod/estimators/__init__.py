"""State estimators: blocks that turn a discrete model and its noise into estimates with a variance."""

from tierod.estimators.augment import augment
from tierod.estimators.kalman import KalmanFilter
from tierod.estimators.luenberger import Luenberger
from tierod.estimators.pole_placement import discrete_poles, observer_gain, reduced_observer_gain
from tierod.estimators.riccati import StationaryGain, stationary_gain
from tierod.estimators.stationary import StationaryFilter
from tierod.estimators.unscented import UnscentedFilter

__all__ = [
    "KalmanFilter",
    "Luenberger",
    "StationaryFilter",
    "StationaryGain",
    "UnscentedFilter",
    "augment",
    "discrete_poles",
    "observer_gain",
    "reduced_observer_gain",
    "stationary_gain",
]
