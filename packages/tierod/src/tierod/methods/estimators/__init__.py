"""State estimators: blocks that compute estimates with variances from a discrete model and its noise."""

from tierod.methods.estimators.augment import augment
from tierod.methods.estimators.fixed_lag import FixedLag
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.luenberger import Luenberger
from tierod.methods.estimators.pole_placement import discrete_poles, observer_gain
from tierod.methods.estimators.riccati import StationaryGain, stationary_gain
from tierod.methods.estimators.stationary import StationaryFilter
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.methods.estimators.unscented import UnscentedFilter

__all__ = [
    "FixedLag",
    "KalmanFilter",
    "Luenberger",
    "StationaryBank",
    "StationaryFilter",
    "StationaryGain",
    "UnscentedFilter",
    "augment",
    "discrete_poles",
    "observer_gain",
    "stationary_gain",
]
