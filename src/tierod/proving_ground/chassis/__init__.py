"""Body, wheels and tyres of the virtual cars."""

from tierod.proving_ground.chassis.single_track import SingleTrack, SingleTrackMotion

__all__ = ["SingleTrack", "SingleTrackMotion"]
