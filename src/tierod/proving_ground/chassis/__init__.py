"""Body, wheels and tyres of the virtual cars."""

from tierod.proving_ground.chassis.single_track import SingleTrack, SingleTrackMotion
from tierod.proving_ground.chassis.suspension import Axle, Kingpins
from tierod.proving_ground.chassis.two_track import TwoTrack, TwoTrackMotion, demonstrator
from tierod.proving_ground.chassis.tyres import TYRES, Tyre

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
