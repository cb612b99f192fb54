"""Body, wheels and tyres of the virtual cars."""

from tierod_lab.ground.chassis.single_track import SingleTrack
from tierod_lab.ground.chassis.two_track import Axle, Kingpins, TwoTrack, demonstrator
from tierod_lab.ground.chassis.tyres import TYRES, Tyre

__all__ = [
    "TYRES",
    "Axle",
    "Kingpins",
    "SingleTrack",
    "TwoTrack",
    "Tyre",
    "demonstrator",
]
