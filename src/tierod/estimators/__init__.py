"""State estimators: blocks that turn a discrete model and its noise into estimates with a variance."""

from tierod.estimators.augment import augment
from tierod.estimators.fixed_lag import FixedLag
from tierod.estimators.interacting import InteractingFilter
from tierod.estimators.kalman import KalmanFilter
from tierod.estimators.luenberger import Luenberger
from tierod.estimators.mixing import switching_of
from tierod.estimators.pole_placement import discrete_poles, observer_gain, reduced_observer_gain
from tierod.estimators.remember import remember
from tierod.estimators.riccati import StationaryGain, stationary_gain
from tierod.estimators.stationary import StationaryFilter
from tierod.estimators.stationary_bank import StationaryBank
from tierod.estimators.unscented import UnscentedFilter

__all__ = [
    "FixedLag",
    "InteractingFilter",
    "KalmanFilter",
    "Luenberger",
    "StationaryBank",
    "StationaryFilter",
    "StationaryGain",
    "UnscentedFilter",
    "augment",
    "discrete_poles",
    "observer_gain",
    "reduced_observer_gain",
    "remember",
    "stationary_gain",
    "switching_of",
]
