"""Sideslip of two real cars without a measured steering torque: race laps and a car park."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod_lab.papers.sideslip import car_park, race_laps
from tierod_lab.papers.sideslip.real_recordings import recorded
from tierod_lab.studies.effort import Effort


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Two real cars",
        (
            "Neither car measures the torque of its steering, so the combined estimator runs on speed, steering angle, "
            "yaw rate and accelerations alone. It is causal and reads no signal that was filtered without lag.",
        ),
    )
    yield from race_laps.items(recorded(race_laps.FILE, race_laps.VEHICLE), effort)
    yield from car_park.items(recorded(car_park.FILE, car_park.VEHICLE))
