"""Body, wheels and tyres of the virtual cars."""

from tierod_lab.ground.chassis.single_track import SingleTrack, SingleTrackMotion
from tierod_lab.ground.chassis.two_track import Axle, Kingpins, TwoTrack, TwoTrackMotion, demonstrator
from tierod_lab.ground.chassis.tyres import TYRES, Tyre

__all__ = [
    "TYRES",
    "Axle",
    "Kingpins",
    "SingleTrack",
    "SingleTrackMotion",
    "TwoTrack",
    "TwoTrackMotion",
    "Tyre",
    "demonstrator",
]
